#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "pled_vins/reliability/anchored_map.hpp"
#include "pled_vins/reliability/bin_counters.hpp"
#include "pled_vins/reliability/entropy_recency.hpp"

namespace pled {

/// W of eq. (6), and the deviation of the weights across the band. Ours: the paper gives neither.
inline constexpr double kBandWidth_px = 5.0;
inline constexpr double kBandSigma_px = kBandWidth_px / 4.0;
/// Columns (of a steep line: rows) of a band that are looked at; of more, every second, third, ...
inline constexpr int kMaxBandColumns = 160;
/// Pixels with events that a band must have to say something, ScoreForm::kClean.
inline constexpr std::uint32_t kFewestBandPixels = 5;

/// What the entropy-recency map says along a line. Means are over the pixels that speak.
struct LineBand {
  double s =
      0.0;  ///< eq. (7): mean of s with weights exp(-delta^2 / 2 sigma^2), delta off the line
  double count_reliability = 1.0;  ///< event_count_reliability(), with the same weights
  /// Mean gradient of q, 1/px, along x and y of the map; part of eq. (17).
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  std::uint32_t pixels = 0;       ///< that speak
  std::uint32_t with_events = 0;  ///< of these
};

/// Reads the band of eq. (6): the pixels of the grid at most W / 2 beside the segment, none beyond
/// its ends.
///
///   kPaper  all of them speak, to the letter: one without events has the s and q that the formulas
///           give for it (0 and less than 0), so mostly empty bands look at rest, and the gradient
///           is that of the border of what has events.
///   kClean  those with events speak; the gradient along x (y) is over those whose both neighbours
///           along it have events too, and 0 where there is none.
///
/// @param start_px, end_px  in the grid as seen from map.reference(); may lie outside
/// @param last  as in AnchoredMap::read
/// @returns nullopt when no pixel of the band lies in the grid, kClean: fewer than
///          kFewestBandPixels speak, when the segment is shorter than 1e-6 px or an end is not
///          finite or farther than 1e6 px. Swapping the ends changes no bit.
/// Cost: at most 8 kMaxBandColumns pixels, five cells each; no allocation.
/// Source: eqs. (6), (7); the gradient by central differences is ours.
[[nodiscard]] std::optional<LineBand> read_line_band(const AnchoredMap& map, BinNumber last,
                                                     const Eigen::Vector2d& start_px,
                                                     const Eigen::Vector2d& end_px,
                                                     ScoreForm form) noexcept;

/// w_EV of a line: z_line = 1 - s_line. Paper, section "Temporal Reliability Estimation".
[[nodiscard]] constexpr double temporal_reliability(const LineBand& band) noexcept {
  return 1.0 - band.s;
}

}  // namespace pled
