#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pled_vins/core/image_view.hpp"

namespace pled::report {

/// An 8-bit grey image that owns its pixels.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> pixels;

  Picture() = default;
  Picture(int width, int height)
      : width_px(width),
        height_px(height),
        pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}
  [[nodiscard]] bool empty() const noexcept { return pixels.empty(); }
  [[nodiscard]] ImageView<const std::uint8_t> view() const noexcept {
    return {pixels.data(), width_px, height_px, width_px};
  }
  [[nodiscard]] std::uint8_t& at(int y, int x) noexcept {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) +
                  static_cast<std::size_t>(x)];
  }
};

/// The image made smaller by the mean over each area; at most its own size.
[[nodiscard]] Picture shrunk(ImageView<const std::uint8_t> image, int width_px);
/// The same by the nearest pixel, for images whose values are names.
[[nodiscard]] Picture thinned(ImageView<const std::uint8_t> image, int width_px);

/// A PNG of the picture, as base64; empty when the library fails.
[[nodiscard]] std::string png_base64(const Picture& picture);
/// The same in no more than `max_bytes` (or 64 pixels wide), made coarser and smaller
/// until it fits.
[[nodiscard]] std::string png_base64_within(const Picture& picture, std::size_t max_bytes);

}  // namespace pled::report
