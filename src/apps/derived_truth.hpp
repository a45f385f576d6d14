#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/imu/preintegration.hpp"
#include "pled_vins/imu/truth_check.hpp"

namespace pled::apps {

/// True states whose velocity and biases were not given but derived.
struct DerivedTruth {
  std::vector<NavState> states;
  TruthUncertainty uncertainty;  ///< of the biases alone: the poses are taken as exact
};

/// For a truth of poses alone that is exact (a simulator's) and dense: velocity by central
/// differences; each bias as the mean of (reading - what the poses' differences say) over the
/// second *before* the state, so that the samples which are then integrated from the state have
/// no part in it. Its variance is that of the white noise's mean plus that of a random walk
/// against its mean over the second before: density^2 / T + walk^2 T / 3.
/// @param poses  increasing stamps; velocity and biases are not read.
/// @param imu    increasing stamps.
/// nullopt when the poses come at less than 100 Hz or are shorter than 1.5 s.
[[nodiscard]] std::optional<DerivedTruth> derive_motion(std::span<const NavState> poses,
                                                        std::span<const ImuSample> imu,
                                                        const ImuNoise& noise);

}  // namespace pled::apps
