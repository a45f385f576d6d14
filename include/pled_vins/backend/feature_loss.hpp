#pragma once

#include <span>

#include "pled_vins/backend/factors.hpp"

namespace pled {

/// Chooses the weight of one point or line: the minimiser of its loss at the states as they are,
/// eq. (9), with what time tells as one more term when the fusion says so. Sets w and w_geometric.
/// @param squared  |r|^2 of each of its sightings, sigmas^2; at least one
void weigh(const FactorSettings& settings, std::span<const double> squared,
           Reliability& reliability) noexcept;

/// After a frame's solve: fuses by the paper where the fusion says so, and keeps the weight for the
/// next frame.
void conclude(const FactorSettings& settings, bool is_line, Reliability& reliability) noexcept;

/// Notes what time tells of a new sighting; NaN: nothing, what was told before stays.
void note_time(double w_temporal, Reliability& reliability) noexcept;

/// Whether a feature that was found to move rests by now: time has told so for a while. Its old
/// sightings are then of another place.
[[nodiscard]] bool parked_again(double w_temporal, const Reliability& reliability) noexcept;

/// False for a landmark that moves or is mistracked, by the mean Cauchy weight of its sightings; as
/// published, weights alone tell.
[[nodiscard]] bool agrees(const FactorSettings& settings, double mean_cauchy_weight) noexcept;

/// Half the loss of one point or line at its weight, weight terms included.
[[nodiscard]] double feature_cost(const FactorSettings& settings, std::span<const double> squared,
                                  const Reliability& reliability) noexcept;

/// One sighting's part of the loss, not half of it, at weight w; the terms of w left out.
[[nodiscard]] double sight_loss(const FactorSettings& settings, double squared, double w) noexcept;

/// What multiplies |r|^2 of one sighting in the normal equations, at weight w.
[[nodiscard]] double sight_weight(const FactorSettings& settings, double squared,
                                  double w) noexcept;

}  // namespace pled
