#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/replay/image_codec.hpp"
#include "drivers/replay/recorded_source.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled::replay {

/// Memory and rules for the frames of a container: which size and stamp a frame may have, and
/// where its pixels go.
class FrameSlots {
 public:
  struct Options {
    ImageSize max;          ///< larger frames are refused
    std::size_t slots = 2;  ///< frames that may be held at once, >= 1
    bool one_size = false;  ///< smaller ones too: the size is known to be `max`, else the first's
  };

  /// Allocates the slots.
  explicit FrameSlots(Options options);

  [[nodiscard]] bool full() const noexcept { return held_ == slots_.size(); }
  /// False, and counted, when the frames have another size.
  [[nodiscard]] bool takes_size(ImageSize size) noexcept;
  /// False, and counted, for a stamp that is not later than the last. Stamps that lie more
  /// than two seconds off are taken: whoever uses them must judge whether they are wrong or
  /// the clock was set.
  [[nodiscard]] bool takes_stamp(std::int64_t t_us) noexcept;
  /// Counts a frame that could not be read.
  void count_unreadable() noexcept { ++faults_.unreadable; }

  /// Where the pixels of the next frame go, row-major; then push() it. Not when full.
  [[nodiscard]] std::span<std::uint8_t> next_slot() noexcept;
  [[nodiscard]] FrameView push(std::int64_t t_us, ImageSize size) noexcept;
  void release() noexcept;

  [[nodiscard]] FrameFaults faults() const noexcept { return faults_; }

 private:
  Options options_;
  std::size_t slot_pixels_;
  std::vector<std::unique_ptr<std::uint8_t[]>> slots_;  ///< not touched before they are used
  std::size_t first_held_ = 0;
  std::size_t held_ = 0;
  ImageSize size_;  ///< of the first frame
  bool has_stamp_ = false;
  std::int64_t last_us_ = 0;
  FrameFaults faults_;
};

}  // namespace pled::replay
