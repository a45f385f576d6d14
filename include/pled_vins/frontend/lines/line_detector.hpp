#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/frontend/lines/config.hpp"
#include "pled_vins/frontend/lines/line_descriptor.hpp"
#include "pled_vins/frontend/lines/line_image.hpp"
#include "pled_vins/frontend/lines/segment.hpp"
#include "pled_vins/frontend/lines/segment_finder.hpp"

namespace pled {

/// A straight edge of one picture.
struct DetectedLine {
  Segment segment;
  std::array<std::array<double, 2>, 2> raw_px{};  ///< start and end, inside the picture
  LineDescriptor descriptor;
};

using DetectedLines = FixedVector<DetectedLine, limits::kMaxLines>;

/// The memory of a LineDetector, whatever the picture's size.
struct LineBuffers {
  int max_width_px = 0;
  int max_height_px = 0;
  std::span<std::uint8_t> filtered;   ///< one per pixel
  std::span<std::uint8_t> shrunk;     ///< one per pixel of the shrunk picture
  std::span<float> row;               ///< one per column
  std::span<GradientPixel> gradient;  ///< one per pixel
};

/// The same as arrays, for pictures up to MaxWidth x MaxHeight pixels. Plain data, no constructor.
template <int MaxWidth, int MaxHeight>
struct LineStorage {
  static constexpr std::size_t kPixels =
      static_cast<std::size_t>(MaxWidth) * static_cast<std::size_t>(MaxHeight);

  std::array<std::uint8_t, kPixels> filtered;
  std::array<std::uint8_t, static_cast<std::size_t>(shrunk_px(MaxWidth)) *
                               static_cast<std::size_t>(shrunk_px(MaxHeight))>
      shrunk;
  std::array<float, static_cast<std::size_t>(MaxWidth)> row;
  std::array<GradientPixel, kPixels> gradient;

  [[nodiscard]] LineBuffers view() noexcept {
    return {MaxWidth, MaxHeight, filtered, shrunk, row, gradient};
  }
};

/// Finds the straight edges of a picture: LSD's pieces, joined; of a time surface the fronts only;
/// laid on the edge; gated by length and bow; longest first; each with its descriptor.
/// No thread, no clock; no allocation but that of find_pieces(): the same pictures give the same
/// bits.
class LineDetector {
 public:
  /// Smallest picture, pixels a side.
  static constexpr int kMinSide_px = 16;

  /// @param config  valid: check(config).key == nullptr
  /// @param camera  its size is that of every picture, kMinSide_px or more; fits the buffers
  LineDetector(const LineConfig& config, const Camera& camera, LinePicture kind,
               const LineBuffers& buffers) noexcept;

  /// @param[out] out  at most config.max_lines, cleared first
  /// @returns false, with `out` empty, when the picture has another size or memory ran out.
  [[nodiscard]] bool detect(ImageView<const std::uint8_t> picture, DetectedLines& out) noexcept;

  [[nodiscard]] const FlatPixels& flat() const noexcept { return flat_; }
  /// Shortest line taken, flat pixels.
  [[nodiscard]] double min_length_px() const noexcept { return min_length_px_; }

 private:
  [[nodiscard]] bool find_segments(ImageView<const std::uint8_t> picture) noexcept;
  void lay_on_edges(ImageView<const GradientPixel> gradient) noexcept;
  void take_longest(ImageView<const GradientPixel> gradient, DetectedLines& out) const noexcept;
  [[nodiscard]] bool pull_inside(Segment& segment, DetectedLine& line) const noexcept;

  LineConfig config_;
  FlatPixels flat_;
  LinePicture kind_;
  LineBuffers buffers_;
  int width_px_;
  int height_px_;
  double min_length_px_;
  double trail_px_;
  std::array<ShrunkPiece, limits::kMaxSegments> pieces_{};
  Segments segments_;
};

}  // namespace pled
