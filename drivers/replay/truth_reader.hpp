#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/replay/line_reader.hpp"
#include "drivers/replay/message.hpp"
#include "pled_vins/core/timestamp.hpp"

namespace pled::replay {

enum class TruthFormat : std::uint8_t {
  kTum,    ///< `t_s px py pz qx qy qz qw`
  kEuroc,  ///< `t_ns,px,py,pz,qw,qx,qy,qz[,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz]`
};

/// One line of ground truth: T_world_body and, where the file has them, velocity and biases.
struct TruthState {
  Timestamp t;
  std::int64_t stamp_ns = 0;
  std::array<double, 3> p_world_body_m{};
  std::array<double, 4> q_world_body_xyzw{0, 0, 0, 1};  ///< as in the file, of length 1
  bool has_motion = false;                              ///< the three below were given
  std::array<double, 3> v_world_body_mps{};
  std::array<double, 3> gyro_bias_radps{};
  std::array<double, 3> accel_bias_mps2{};
};

/// A ground-truth file, line by line.
class TruthReader {
 public:
  /// Errors: as File::open.
  [[nodiscard]] static Result<TruthReader> open(const std::string& path, TruthFormat format);

  /// Errors: kEndOfStream, kBadNumber (a line that does not read, or a quaternion
  /// whose length is not 1 within 0.1; counted, call again), kIoFailure.
  [[nodiscard]] Result<TruthState> next() noexcept;

  [[nodiscard]] std::uint64_t malformed() const noexcept { return malformed_; }
  [[nodiscard]] std::string_view last_message() const noexcept { return message_.text(); }

 private:
  TruthReader(LineReader lines, std::string path, TruthFormat format);

  LineReader lines_;
  std::string path_;
  TruthFormat format_;
  Message message_;
  std::uint64_t malformed_ = 0;
};

}  // namespace pled::replay
