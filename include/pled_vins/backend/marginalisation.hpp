#pragma once

#include <cstdint>

#include "pled_vins/backend/normal_equations.hpp"

namespace pled {

/// What becomes of a point or line that was first seen from the oldest state and still is.
enum class LivePointRule : std::uint8_t {
  kSplit,      ///< the older half of its sightings goes into the prior, the rest goes on
  kDrop,       ///< the anchor's sighting is forgotten
  kEliminate,  ///< all sightings go into the prior; the point starts anew
};

/// Takes states out of the window and leaves what they knew in the prior. A sighting is
/// counted once: in the prior or among the window's factors, never in both.
class Marginaliser {
 public:
  explicit Marginaliser(LivePointRule rule = LivePointRule::kSplit) noexcept : rule_(rule) {}

  void set_rule(LivePointRule rule) noexcept { rule_ = rule; }

  /// Takes state `k` out with its inertial, standstill and prior factors. Points and lines seen
  /// from the oldest state (k = 0) go by the rule; other states' sightings are dropped.
  /// False when the result was not finite: the window then goes on without a prior.
  bool marginalise(SlidingWindow& window, const RigCalibration& rig, const FactorSettings& settings,
                   std::size_t k) noexcept;

 private:
  void add_points(SlidingWindow& window, const RigCalibration& rig,
                  const FactorSettings& settings) noexcept;
  void add_lines(SlidingWindow& window, const RigCalibration& rig,
                 const FactorSettings& settings) noexcept;
  bool eliminate(SlidingWindow& window, std::size_t k) noexcept;
  void schur(std::size_t k) noexcept;
  bool factorise(SlidingWindow& window) noexcept;

  LivePointRule rule_;
  NormalEquations equations_;
  PriorMatrix H_;
  PriorVector b_;
};

}  // namespace pled
