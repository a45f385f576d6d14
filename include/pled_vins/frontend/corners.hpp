#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled {

/// The structure tensor is averaged over (2k+1) x (2k+1) pixels.
inline constexpr int kCornerWindowRadius = 2;
/// Nearest that a corner may be to the image's edge, pixels.
inline constexpr int kCornerBorderPx = 6;
/// Cells over the image; each offers at most one corner in a frame.
inline constexpr std::size_t kMaxCornerCells = 2048;
/// Rows of floats that corner_response needs as scratch.
inline constexpr std::size_t kCornerScratchRows = 3 + 3 * (2 * kCornerWindowRadius + 1);

/// One new corner at an integer pixel.
struct Corner {
  std::int16_t x_px = 0;
  std::int16_t y_px = 0;
  float score = 0.0F;  ///< smaller eigenvalue of the mean structure tensor, (grey/px)^2
};

/// Shi-Tomasi: the smaller eigenvalue of the mean of [gx^2 gxgy; gxgy gy^2] over the window, with
/// g the central difference of pyramid level 0 in grey per pixel. `out` has the size of `level`
/// (with its margin filled); pixels within kCornerBorderPx of the edge get 0. `scratch` holds
/// kCornerScratchRows rows of level.width values.
void corner_response(ImageView<const std::int16_t> level, std::span<float> scratch,
                     ImageView<float> out) noexcept;

/// What select_corners may take.
struct CornerDemand {
  std::size_t count = 0;          ///< at most so many
  float min_score = 0.0F;         ///< (grey/px)^2
  float min_distance_px = 10.0F;  ///< between any two, and to the occupied places
  std::size_t total_points = 0;   ///< tracks wanted in the whole image, for the share of a tile
};

/// Marks a disc around (x, y), clipped to the mask.
void paint_disc(ImageView<std::uint8_t> mask, float x_px, float y_px, float radius_px) noexcept;

/// The best corners outside the painted mask, best first within a tile's share, so that one
/// textured region does not take all; what is left over goes to the best anywhere. `cells` holds
/// kMaxCornerCells items. `occupied` are the places of the tracks.
void select_corners(ImageView<const float> response, ImageView<const std::uint8_t> mask,
                    std::span<const Corner> occupied, const CornerDemand& demand,
                    std::span<Corner> cells, FixedVector<Corner, limits::kMaxPoints>& out) noexcept;

}  // namespace pled
