#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "drivers/replay/recording.hpp"
#include "pled_vins/core/image_view.hpp"

namespace pled::report {

/// The label images of a recording, asked for in the order of time.
class Labels {
 public:
  /// Without labels, or when they cannot be read, every image is absent.
  explicit Labels(const replay::Recording* recording);

  /// The labels of the frame with this stamp, until the next call; later stamps only.
  [[nodiscard]] std::optional<ImageView<const std::uint8_t>> at(std::int64_t stamp_ns);

 private:
  void advance();

  std::unique_ptr<replay::FrameFileSource> source_;
  std::optional<FrameView> current_;
};

/// Whether the pixel lies on something that moves.
[[nodiscard]] bool is_moving(ImageView<const std::uint8_t> labels, double u_px, double v_px);

}  // namespace pled::report
