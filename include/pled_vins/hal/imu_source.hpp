#pragma once

#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/result.hpp"

namespace pled {

/// Inertial samples in the order in which they arrived: stamps may repeat or go
/// back, and the reader judges them. One reader thread.
class ImuSource {
 public:
  virtual ~ImuSource() = default;
  virtual Result<void> start() noexcept = 0;
  /// Waits for the next sample. Never allocates. Errors: kTimeout (call again),
  /// kBadNumber (this sample was unreadable; call again), kDisconnected,
  /// kEndOfStream (final; recordings only).
  virtual Result<ImuSample> read(Duration timeout) noexcept = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace pled
