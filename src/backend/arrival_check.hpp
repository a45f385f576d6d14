#pragma once

#include "pled_vins/backend/factors.hpp"

namespace pled {

/// Asks of every point and line that the newest state sees whether it has come where the inertial
/// prediction of that state lets it come: a point onto the piece of its epipolar line over the
/// depths it may have, a line onto its picture, within what prediction and tracker may be wrong by.
/// A sighting that fails is taken out before the solve, so that an object that fills the view
/// cannot carry the estimate with it; what fails in three frames on end is rejected. Ours. Call
/// with the newest state as predicted, its sightings in the books.
void turn_away_movers(SlidingWindow& window, const RigCalibration& rig,
                      const FactorSettings& settings) noexcept;

}  // namespace pled
