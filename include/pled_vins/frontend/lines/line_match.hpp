#pragma once

#include <cstdint>
#include <span>

#include "pled_vins/frontend/lines/line_descriptor.hpp"
#include "pled_vins/frontend/lines/line_detector.hpp"
#include "pled_vins/frontend/lines/segment.hpp"

namespace pled {

/// Where a known line should be in a new picture.
struct ExpectedLine {
  Segment segment;
  LineDescriptor descriptor;  ///< as last seen
  bool was_seen = true;       ///< in the picture before; others get what those leave
};

/// No line of the new picture.
inline constexpr std::int16_t kNoLine = -1;

/// Finds the expected lines among those seen. Where a line is comes first: same bright and active
/// side, within 6 degrees and `search_px` of the expected one over their common part, which is half
/// of the shorter or more. The nearest is taken if it is 2 px nearer than the next; of those as
/// near, the one whose descriptor agrees (below 40 of 256 bits) and by 10 bits more than the
/// others'. A match is mutual: chosen so from both sides. Ambiguous lines get none.
/// Cost: O(expected x seen), 24 KB of stack.
/// @param expected  at most limits::kMaxLines
/// @param[out] match  for each expected line the index of one seen, or kNoLine; same size
void match_lines(std::span<const ExpectedLine> expected, std::span<const DetectedLine> seen,
                 double search_px, std::span<std::int16_t> match) noexcept;

}  // namespace pled
