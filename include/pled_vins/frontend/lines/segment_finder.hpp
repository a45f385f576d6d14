#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/image_view.hpp"

namespace pled {

/// One piece as LSD finds it, in the shrunk picture's pixels.
struct ShrunkPiece {
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Straight edges of a picture that is shrunk and blurred already, by OpenCV's LSD with its own
/// standard parameters otherwise (refinement 1, 22.5 degrees, density 0.7, 1024 bins). The longest
/// come first, as many as fit; those below `min_length_px` are left out.
///
/// The one function of the lines that allocates: OpenCV's detector takes about 40 bytes a pixel of
/// the shrunk picture for the duration of the call and gives them back.
/// @param shrunk  8 px or more a side
/// @param[out] found  how many were written to `pieces`
/// @returns false, with found 0, when OpenCV failed for want of memory.
[[nodiscard]] bool find_pieces(ImageView<const std::uint8_t> shrunk, double min_length_px,
                               std::span<ShrunkPiece> pieces, std::size_t& found) noexcept;

}  // namespace pled
