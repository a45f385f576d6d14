#include "pled_vins/frontend/lines/segment.hpp"

#include <algorithm>
#include <cmath>

namespace pled {

std::optional<Eigen::Vector2d> FlatPixels::from_raw(const Eigen::Vector2d& raw_px) const noexcept {
  if (camera_.calibration().distortion == Distortion::kNone) return raw_px;
  const std::optional<Eigen::Vector2d> b = camera_.undistort(raw_px);
  if (!b) return std::nullopt;
  return from_bearing(*b);
}

std::optional<Eigen::Vector2d> FlatPixels::to_raw(const Eigen::Vector2d& flat_px) const noexcept {
  if (camera_.calibration().distortion == Distortion::kNone) return flat_px;
  return camera_.project(bearing(flat_px).homogeneous());
}

Eigen::Vector2d FlatPixels::bearing(const Eigen::Vector2d& flat_px) const noexcept {
  const CameraCalibration& c = camera_.calibration();
  return {(flat_px.x() - c.cx_px) / c.fx_px, (flat_px.y() - c.cy_px) / c.fy_px};
}

Eigen::Vector2d FlatPixels::from_bearing(const Eigen::Vector2d& bearing_xy) const noexcept {
  const CameraCalibration& c = camera_.calibration();
  return {c.fx_px * bearing_xy.x() + c.cx_px, c.fy_px * bearing_xy.y() + c.cy_px};
}

Eigen::Vector2d Segment::direction() const noexcept {
  const Eigen::Vector2d along = end() - start();
  const double length = along.norm();
  if (!(length > 0.0)) return {1.0, 0.0};
  return along / length;
}

BesideSegment beside(const Segment& a, const Segment& other) noexcept {
  const Eigen::Vector2d d = a.direction();
  const Eigen::Vector2d n(d.y(), -d.x());
  const Eigen::Vector2d from = other.start() - a.start();
  const Eigen::Vector2d to = other.end() - a.start();
  const double s0 = from.dot(d);
  const double s1 = to.dot(d);
  BesideSegment out;
  out.ends_e_px = {from.dot(n), to.dot(n)};
  const Eigen::Vector2d along = other.direction();
  out.cosine = d.dot(along);
  out.sine = d.x() * along.y() - d.y() * along.x();
  const double low = std::max(0.0, std::min(s0, s1));
  const double high = std::min(a.length_px(), std::max(s0, s1));
  out.common_px = high - low;
  const double slope =
      std::abs(s1 - s0) > 1e-9 ? (out.ends_e_px[1] - out.ends_e_px[0]) / (s1 - s0) : 0.0;
  const double e_low = out.ends_e_px[0] + slope * (low - s0);
  const double e_high = out.ends_e_px[0] + slope * (high - s0);
  out.offset_px = 0.5 * (e_low + e_high);
  out.farthest_px = std::max(std::abs(e_low), std::abs(e_high));
  return out;
}

}  // namespace pled
