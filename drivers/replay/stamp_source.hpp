#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "pled_vins/hal/frame_source.hpp"

namespace pled::replay {

/// Observation times without pictures: frames whose image is empty, for an estimator that sees by
/// events alone.
class StampSource final : public FrameSource {
 public:
  /// @param stamps_ns  rising, but where a clock was set
  explicit StampSource(std::vector<std::int64_t> stamps_ns) : stamps_ns_(std::move(stamps_ns)) {}

  /// Times from the first to the last, `rate_hz` of them a second.
  [[nodiscard]] static std::vector<std::int64_t> regular(std::int64_t first_ns,
                                                         std::int64_t last_ns, double rate_hz);

  Result<void> start() noexcept override { return {}; }
  Result<FrameView> acquire(Duration timeout) noexcept override;
  void release() noexcept override {}
  void stop() noexcept override {}

 private:
  std::vector<std::int64_t> stamps_ns_;
  std::size_t next_ = 0;
};

}  // namespace pled::replay
