#include "drivers/replay/stamp_source.hpp"

#include <cmath>

namespace pled::replay {

std::vector<std::int64_t> StampSource::regular(std::int64_t first_ns, std::int64_t last_ns,
                                               double rate_hz) {
  std::vector<std::int64_t> stamps_ns;
  const double step_ns = 1e9 / rate_hz;
  for (std::int64_t k = 0;; ++k) {
    const std::int64_t t_ns = first_ns + std::llround(static_cast<double>(k) * step_ns);
    if (t_ns > last_ns) return stamps_ns;
    stamps_ns.push_back(t_ns);
  }
}

Result<FrameView> StampSource::acquire(Duration /*timeout*/) noexcept {
  if (next_ == stamps_ns_.size()) return Error{ErrorCode::kEndOfStream, 0};
  FrameView frame;
  frame.stamp_ns = stamps_ns_[next_++];
  frame.t = Timestamp{(frame.stamp_ns + (frame.stamp_ns < 0 ? -500 : 500)) / 1000};
  return frame;
}

}  // namespace pled::replay
