#pragma once

#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/result.hpp"

namespace pled {

/// Where poses go: a file, an autopilot, a network.
class PoseSink {
 public:
  virtual ~PoseSink() = default;
  virtual Result<void> write(const PoseEstimate& pose) noexcept = 0;
};

}  // namespace pled
