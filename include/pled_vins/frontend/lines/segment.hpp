#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// What the picture shows where nothing is.
enum class LinePicture : std::uint8_t {
  kGrey,           ///< any grey: a frame, or the brightness that events add up to
  kSurface,        ///< 0: a time surface without polarity
  kSignedSurface,  ///< 128: a time surface with polarity
};

/// Pixels of the same camera without lens distortion, where straight edges are straight.
class FlatPixels {
 public:
  explicit FlatPixels(const Camera& camera) noexcept : camera_(camera) {}

  /// nullopt where the lens model has no bearing.
  [[nodiscard]] std::optional<Eigen::Vector2d> from_raw(
      const Eigen::Vector2d& raw_px) const noexcept;
  /// nullopt beyond the lens model. The pixel may lie outside the picture.
  [[nodiscard]] std::optional<Eigen::Vector2d> to_raw(
      const Eigen::Vector2d& flat_px) const noexcept;
  /// On the plane z = 1.
  [[nodiscard]] Eigen::Vector2d bearing(const Eigen::Vector2d& flat_px) const noexcept;
  [[nodiscard]] Eigen::Vector2d from_bearing(const Eigen::Vector2d& bearing_xy) const noexcept;
  [[nodiscard]] const Camera& camera() const noexcept { return camera_; }

 private:
  Camera camera_;
};

/// A straight edge. Going from start to end its bright side lies along normal(): to the left on a
/// screen, where y points down. So each edge has one direction, and ends keep their names.
struct Segment {
  std::array<double, 2> start_px{};  ///< flat pixels
  std::array<double, 2> end_px{};
  float steepness = 0.0F;  ///< mean slope of grey across it, grey/px
  /// Whether events are on the bright side; of a frame, which has none, always true.
  bool active_is_bright = true;

  [[nodiscard]] Eigen::Vector2d start() const noexcept { return {start_px[0], start_px[1]}; }
  [[nodiscard]] Eigen::Vector2d end() const noexcept { return {end_px[0], end_px[1]}; }
  [[nodiscard]] double length_px() const noexcept { return (end() - start()).norm(); }
  /// Unit vector from start to end; (1, 0) for a point.
  [[nodiscard]] Eigen::Vector2d direction() const noexcept;
  /// Unit vector to the bright side, (d_y, -d_x).
  [[nodiscard]] Eigen::Vector2d normal() const noexcept {
    const Eigen::Vector2d d = direction();
    return {d.y(), -d.x()};
  }
  void set(const Eigen::Vector2d& from, const Eigen::Vector2d& to) noexcept {
    start_px = {from.x(), from.y()};
    end_px = {to.x(), to.y()};
  }
};

using Segments = FixedVector<Segment, limits::kMaxSegments>;

/// How one segment lies beside another, `a`, in whose frame all of it is told: s along a from its
/// start, e along a.normal().
struct BesideSegment {
  double cosine = 1.0;  ///< of the angle from a's direction to the other's
  double sine = 0.0;
  double common_px = 0.0;    ///< length of a that both cover; below 0: the gap between them
  double offset_px = 0.0;    ///< mean e over the common part, or in the middle of the gap
  double farthest_px = 0.0;  ///< largest |e| at the ends of the common part
  std::array<double, 2> ends_e_px{};  ///< e of the other's start and end

  /// From a's direction, in (-pi, pi]. The one costly figure: asked for last.
  [[nodiscard]] double angle_rad() const noexcept { return std::atan2(sine, cosine); }
};
[[nodiscard]] BesideSegment beside(const Segment& a, const Segment& other) noexcept;

/// False only when the angle from a's direction to the other's is above `angle_rad`, which is at
/// most 0.5: told without a square root, for the many pairs that have nothing to do with each
/// other.
[[nodiscard]] inline bool may_run_alike(const Segment& a, const Segment& other,
                                        double angle_rad) noexcept {
  const Eigen::Vector2d u = a.end() - a.start();
  const Eigen::Vector2d v = other.end() - other.start();
  // tan(x) <= x + x^3 / 2 there; zero vectors and NaN pass.
  const double tangent = angle_rad * (1.0 + 0.5 * angle_rad * angle_rad);
  return !(std::abs(u.x() * v.y() - u.y() * v.x()) > tangent * u.dot(v));
}

}  // namespace pled
