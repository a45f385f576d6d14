#pragma once

#include <cstddef>

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/window.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled {

/// Keeps the lines of a window, as LandmarkBook keeps its points.
class LineBook {
 public:
  /// Both are kept by reference.
  LineBook(const RigCalibration& rig, const FactorSettings& settings,
           std::size_t min_observations) noexcept
      : rig_(rig), settings_(settings), min_observations_(min_observations) {}

  /// Notes the lines of a frame as seen from window state `state`; forgets lines that ended and are
  /// seen from less than two states.
  void observe(SlidingWindow& window, const FrameMeasurement& frame,
               std::size_t state) const noexcept;

  /// Triangulates new lines and picks those that take part in the next solve: at most
  /// limits::kMaxLines, living and long ones first. Returns how many.
  std::size_t prepare(SlidingWindow& window) const noexcept;

  /// After a solve: weight of every line; those that do not fit are rejected.
  void judge(SlidingWindow& window) const noexcept;

 private:
  void triangulate(SlidingWindow& window, LineLandmark& line) const noexcept;

  const RigCalibration& rig_;
  const FactorSettings& settings_;
  std::size_t min_observations_;
};

}  // namespace pled
