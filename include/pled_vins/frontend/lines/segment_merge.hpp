#pragma once

#include "pled_vins/frontend/lines/segment.hpp"

namespace pled {

/// Joins pieces of one edge: directions within 3 degrees (bright side included), ends within 2 px
/// of each other's line, and a gap of at most 10 px or none. The joint is the total least squares
/// line of both, each taken as an evenly laid mass. Longest first, before and after.
/// Cost: O(size^2).
void merge_collinear(Segments& segments) noexcept;

/// Of each edge's two sides on a time surface, the steep one where events come and the gentle one
/// where they fade, the steep one stays: two that face each other over their active sides, within
/// `trail_px`, side by side over half of the shorter. The order of the others stays.
/// Cost: O(size^2).
void keep_fronts(double trail_px, Segments& segments) noexcept;

}  // namespace pled
