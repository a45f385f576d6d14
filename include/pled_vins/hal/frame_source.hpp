#pragma once

#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/result.hpp"

namespace pled {

/// Grey frames, oldest first. One reader thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual Result<void> start() noexcept = 0;
  /// Waits for the next frame. Errors: kTimeout (call again), kCorrupt or
  /// kTruncated (this frame is lost and counted; call again), kDisconnected,
  /// kEndOfStream (final; recordings only).
  virtual Result<FrameView> acquire(Duration timeout) noexcept = 0;
  /// Gives back the oldest acquired frame.
  virtual void release() noexcept = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace pled
