#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/replay/line_reader.hpp"
#include "drivers/replay/message.hpp"
#include "drivers/replay/recorded_source.hpp"

namespace pled::replay {

enum class ImuFormat : std::uint8_t {
  kRpg,    ///< `t_s ax ay az gx gy gz`
  kEuroc,  ///< `t_ns,gx,gy,gz,ax,ay,az`
};

/// An inertial text file, line by line. m/s^2 and rad/s, body frame. Stamps are
/// read exactly and rounded to 1 us.
class ImuFileSource final : public RecordedImuSource {
 public:
  /// Errors: as File::open.
  [[nodiscard]] static Result<std::unique_ptr<ImuFileSource>> open(const std::string& path,
                                                                   ImuFormat format);

  /// Reading begins where open() or the last read left it.
  Result<void> start() noexcept override { return {}; }
  /// Errors: kEndOfStream, kBadNumber (a line that does not read; counted, call
  /// again, last_message() says which), kIoFailure. Detail: line.
  Result<ImuSample> read(Duration timeout) noexcept override;
  void stop() noexcept override {}

  [[nodiscard]] std::uint64_t malformed() const noexcept override { return malformed_; }
  /// Words for the last kBadNumber: file, line and what was expected.
  [[nodiscard]] std::string_view last_message() const noexcept override { return message_.text(); }
  [[nodiscard]] double progress() const noexcept override;

 private:
  ImuFileSource(LineReader lines, std::string path, ImuFormat format);

  LineReader lines_;
  std::string path_;
  ImuFormat format_;
  Message message_;
  std::uint64_t malformed_ = 0;
};

}  // namespace pled::replay
