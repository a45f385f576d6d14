#pragma once

#include <cstdint>
#include <optional>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/frontend/lines/line_image.hpp"
#include "pled_vins/frontend/lines/segment.hpp"

namespace pled {

/// Gives a piece its direction (bright side along the normal), steepness and active side, from the
/// grey 1.5 px to its sides.
/// @param segment  ends in the picture, flat pixels; untouched when false
/// @returns false when it lies on no edge: less than 1 grey/px across, or at the picture's border.
[[nodiscard]] bool look_across(ImageView<const std::uint8_t> picture, LinePicture kind,
                               const FlatPixels& flat, Segment& segment) noexcept;

/// A segment laid on its edge, and how far the edge bows from it.
struct FittedEdge {
  Segment segment;      ///< ends moved across the segment only
  double bow_px = 0.0;  ///< from the chord's middle, flat pixels
};

/// Least squares of the places where grey rises most within 2 px of the segment, 8 to 32 of them;
/// those more than 1 px off the first fit are left out. Ours: LSD's own rectangle takes in whole
/// regions, and pieces of a bowed line say nothing of its bow. In flat pixels, so a lens bends
/// nothing.
/// @returns nullopt when half of the segment has no edge.
[[nodiscard]] std::optional<FittedEdge> fit_edge(ImageView<const GradientPixel> gradient,
                                                 const FlatPixels& flat,
                                                 const Segment& segment) noexcept;

}  // namespace pled
