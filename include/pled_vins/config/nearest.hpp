#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace pled {

/// Insertions, deletions, substitutions and swaps of neighbours between two words.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that `word` most likely meant; empty when there are none. A
/// dotted candidate is compared whole and by its last part.
[[nodiscard]] std::string_view nearest(std::string_view word,
                                       std::span<const std::string_view> candidates);

}  // namespace pled
