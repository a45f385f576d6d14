#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "pled_vins/backend/factors.hpp"

namespace pled {

/// Residuals and Jacobians of the first `count` sightings of one point or line.
template <typename Jacobians>
struct Sights {
  std::size_t count = 0;
  std::array<Eigen::Vector2d, limits::kWindowStates> r;
  std::array<Jacobians, limits::kWindowStates> J;
  std::array<double, limits::kWindowStates> squares;  ///< |r|^2

  [[nodiscard]] std::span<const double> squared() const noexcept {
    return std::span(squares).first(count);
  }
};
using PointSights = Sights<PointJacobians>;
using LineSights = Sights<LineJacobians>;

/// The sightings at the estimate, Jacobians as in evaluate_point() and evaluate_line().
void evaluate_sights(const SlidingWindow& window, const RigCalibration& rig,
                     const FactorSettings& settings, const Landmark& landmark, std::size_t count,
                     PointSights& out) noexcept;
void evaluate_sights(const SlidingWindow& window, const RigCalibration& rig,
                     const FactorSettings& settings, const LineLandmark& landmark,
                     std::size_t count, LineSights& out) noexcept;

/// Squared residuals alone, of every sighting.
struct SquaredSights {
  std::array<double, limits::kWindowStates> squares;
  std::size_t count = 0;
  bool visible = true;  ///< in front of every camera, or with a picture in it

  [[nodiscard]] std::span<const double> span() const noexcept {
    return std::span(squares).first(count);
  }
};
[[nodiscard]] SquaredSights squared_sights(const SlidingWindow& window, const RigCalibration& rig,
                                           const FactorSettings& settings,
                                           const Landmark& landmark) noexcept;
[[nodiscard]] SquaredSights squared_sights(const SlidingWindow& window, const RigCalibration& rig,
                                           const FactorSettings& settings,
                                           const LineLandmark& landmark) noexcept;

/// Numbers of a point and of a line.
inline constexpr int kPointDim = 3;
inline constexpr int kLineDim = 4;

/// Gauss-Newton equations of one landmark with N numbers of its own, and how they are tied to those
/// of the states that see it.
template <int N>
struct LandmarkBlocks {
  std::size_t count = 0;  ///< states
  std::array<std::uint8_t, limits::kWindowStates> states{};
  std::array<Eigen::Matrix<double, kPoseDim, N>, limits::kWindowStates> W;
  Eigen::Matrix<double, kExtrinsicDim, N> W_extrinsic;
  Eigen::Matrix<double, 1, N> W_time_shift;
  Eigen::Matrix<double, N, N> h;
  Eigen::Matrix<double, N, 1> g;

  void clear() noexcept {
    count = 0;
    W_extrinsic.setZero();
    W_time_shift.setZero();
    h.setZero();
    g.setZero();
  }
  /// The block of a state, new and zero if it is not there yet; states come in ascending order.
  [[nodiscard]] std::size_t block_of(std::uint8_t state) noexcept {
    for (std::size_t i = 0; i < count; ++i)
      if (states[i] == state) return i;
    states[count] = state;
    W[count].setZero();
    return count++;
  }
};
using PointBlocks = LandmarkBlocks<kPointDim>;
using LineBlocks = LandmarkBlocks<kLineDim>;

}  // namespace pled
