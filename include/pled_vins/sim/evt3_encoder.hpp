#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pled_vins/core/messages.hpp"

namespace pled::sim {

/// Events to Prophesee EVT 3.0 words (16 bits, little endian), with the word types
/// TIME_HIGH, TIME_LOW, ADDR_Y, ADDR_X, VECT_BASE_X, VECT_12 and VECT_8. Decoding
/// gives the same events in the same order.
///
/// Neighbours in a row that share time and polarity become one vector group
/// (12 + 12 + 8 pixels) when that is shorter. TIME_HIGH is sent for every 4096 us,
/// also when nothing happens, so that a reader can tell a wrap (16.78 s) from a loss.
class Evt3Encoder {
 public:
  explicit Evt3Encoder(int width_px) noexcept : width_px_(width_px) {}

  /// Appends the words of `events` to `bytes`. Times >= 0 and never decreasing, also
  /// from call to call; x < width.
  void encode(std::span<const Event> events, std::vector<std::byte>& bytes);

  /// The header of a RAW file, as far as "% end".
  [[nodiscard]] static std::string raw_header(int width_px, int height_px);

 private:
  void put_time(std::int64_t t_us, std::vector<std::byte>& bytes);
  void put_vector(std::span<const Event> run, std::vector<std::byte>& bytes) const;

  int width_px_;
  std::int64_t high_ = -1;  // last TIME_HIGH sent, not wrapped
  std::int64_t low_ = -1;
  int row_ = -1;
};

}  // namespace pled::sim
