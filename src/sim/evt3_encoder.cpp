#include "pled_vins/sim/evt3_encoder.hpp"

#include <algorithm>

namespace pled::sim {
namespace {

enum Word : std::uint32_t {
  kAddrY = 0x0,
  kAddrX = 0x2,
  kVectBaseX = 0x3,
  kVect12 = 0x4,
  kVect8 = 0x5,
  kTimeLow = 0x6,
  kTimeHigh = 0x8,
};

constexpr int kGroupPx = 32;            // 12 + 12 + 8
constexpr std::size_t kGroupWords = 4;  // base and three masks

void put(Word type, std::uint32_t payload, std::vector<std::byte>& bytes) {
  bytes.push_back(static_cast<std::byte>(payload & 0xffU));
  bytes.push_back(static_cast<std::byte>(((payload >> 8U) & 0x0fU) | (type << 4U)));
}

/// x with the polarity in bit 11.
std::uint32_t address(std::uint32_t x, Polarity polarity) noexcept {
  return (x & 0x7ffU) | (polarity == Polarity::kOn ? 0x800U : 0U);
}

/// Events from `first` on that one vector group can hold: same time, row and
/// polarity, columns rising, within 32 pixels.
std::size_t run_length(std::span<const Event> events, std::size_t first, int width_px) noexcept {
  const Event& head = events[first];
  const int base = std::min<int>(head.x_px, width_px - kGroupPx);
  std::size_t n = 1;
  for (; first + n < events.size(); ++n) {
    const Event& e = events[first + n];
    if (e.t != head.t || e.y_px != head.y_px || e.polarity != head.polarity) break;
    if (e.x_px <= events[first + n - 1].x_px || e.x_px >= base + kGroupPx) break;
  }
  return n;
}

}  // namespace

std::string Evt3Encoder::raw_header(int width_px, int height_px) {
  const std::string w = std::to_string(width_px);
  const std::string h = std::to_string(height_px);
  return "% evt 3.0\n% format EVT3;width=" + w + ";height=" + h + "\n% geometry " + w + "x" + h +
         "\n% end\n";
}

void Evt3Encoder::put_time(std::int64_t t_us, std::vector<std::byte>& bytes) {
  const std::int64_t high = t_us >> 12;
  for (; high_ < high; low_ = -1)
    put(kTimeHigh, static_cast<std::uint32_t>(++high_ & 0xfff), bytes);
  const std::int64_t low = t_us & 0xfff;
  if (low == low_) return;
  put(kTimeLow, static_cast<std::uint32_t>(low), bytes);
  low_ = low;
}

void Evt3Encoder::put_vector(std::span<const Event> run, std::vector<std::byte>& bytes) const {
  const int base = std::min<int>(run.front().x_px, width_px_ - kGroupPx);
  std::uint32_t mask = 0;
  for (const Event& e : run) mask |= 1U << static_cast<std::uint32_t>(e.x_px - base);
  put(kVectBaseX, address(static_cast<std::uint32_t>(base), run.front().polarity), bytes);
  put(kVect12, mask & 0xfffU, bytes);
  put(kVect12, (mask >> 12U) & 0xfffU, bytes);
  put(kVect8, mask >> 24U, bytes);
}

void Evt3Encoder::encode(std::span<const Event> events, std::vector<std::byte>& bytes) {
  for (std::size_t i = 0; i < events.size();) {
    const Event& e = events[i];
    put_time(e.t.us, bytes);
    if (e.y_px != row_) put(kAddrY, e.y_px & 0x7ffU, bytes);
    row_ = e.y_px;
    const std::size_t run = width_px_ >= kGroupPx ? run_length(events, i, width_px_) : 1;
    if (run > kGroupWords) {
      put_vector(events.subspan(i, run), bytes);
      i += run;
    } else {
      put(kAddrX, address(e.x_px, e.polarity), bytes);
      ++i;
    }
  }
}

}  // namespace pled::sim
