#include "pled_vins/frontend/lines/segment_merge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <tuple>

namespace pled {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMergeAngle_rad = 3.0 * kDegree;
constexpr double kMergeOffset_px = 2.0;
constexpr double kMergeGap_px = 10.0;

/// Sides of one edge may diverge: the trail of a line that turns is a wedge.
constexpr double kFacingAngle_rad = 12.0 * kDegree;
constexpr double kFacingShare = 0.5;
/// Sides this near belong to one edge, however alike they are.
constexpr double kThinTrail_px = 3.0;
/// Farther apart the weaker side is a trail only if it is this much less steep.
constexpr float kTrailSteepness = 0.85F;

bool is_longer(const Segment& a, const Segment& b) noexcept {
  return std::tuple(-a.length_px(), a.start_px, a.end_px) <
         std::tuple(-b.length_px(), b.start_px, b.end_px);
}

bool belong_together(const Segment& longer, const Segment& shorter) noexcept {
  if (longer.active_is_bright != shorter.active_is_bright) return false;
  const BesideSegment at = beside(longer, shorter);
  if (!(at.common_px >= -kMergeGap_px)) return false;
  if (!(std::max(std::abs(at.ends_e_px[0]), std::abs(at.ends_e_px[1])) <= kMergeOffset_px))
    return false;
  if (!(std::abs(at.angle_rad()) <= kMergeAngle_rad)) return false;
  // The other way round by the nearer end alone: a short piece says little of what is far off.
  const BesideSegment back = beside(shorter, longer);
  return std::min(std::abs(back.ends_e_px[0]), std::abs(back.ends_e_px[1])) <= kMergeOffset_px;
}

Segment joint(const Segment& a, const Segment& b) noexcept {
  const double mass_a = a.length_px();
  const double mass_b = b.length_px();
  const double mass = mass_a + mass_b;
  const Eigen::Vector2d middle_a = 0.5 * (a.start() + a.end());
  const Eigen::Vector2d middle_b = 0.5 * (b.start() + b.end());
  const Eigen::Vector2d middle = (mass_a * middle_a + mass_b * middle_b) / mass;
  // Second moments: of an even mass L along d about its middle, L^3 / 12 d d^T.
  Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
  const auto add = [&](const Segment& s, double m, const Eigen::Vector2d& at) {
    const Eigen::Vector2d d = s.direction();
    M += m * (at - middle) * (at - middle).transpose() + m * m * m / 12.0 * d * d.transpose();
  };
  add(a, mass_a, middle_a);
  add(b, mass_b, middle_b);
  const double angle = 0.5 * std::atan2(2.0 * M(0, 1), M(0, 0) - M(1, 1));
  Eigen::Vector2d d(std::cos(angle), std::sin(angle));
  if (d.dot(a.direction()) < 0.0) d = -d;
  double low = 0.0;
  double high = 0.0;
  for (const Eigen::Vector2d& end : {a.start(), a.end(), b.start(), b.end()}) {
    low = std::min(low, d.dot(end - middle));
    high = std::max(high, d.dot(end - middle));
  }
  Segment out = a;
  out.set(middle + low * d, middle + high * d);
  out.steepness = static_cast<float>(
      (mass_a * static_cast<double>(a.steepness) + mass_b * static_cast<double>(b.steepness)) /
      mass);
  return out;
}

/// Joins to segment i whatever belongs to it, until nothing more does.
void absorb_into(std::size_t i, Segments& segments) noexcept {
  for (std::size_t k = i + 1; k < segments.size();) {
    if (!may_run_alike(segments[i], segments[k], kMergeAngle_rad)) {
      ++k;
      continue;
    }
    const bool swap = segments[k].length_px() > segments[i].length_px();
    const Segment& longer = segments[swap ? k : i];
    const Segment& shorter = segments[swap ? i : k];
    if (!belong_together(longer, shorter)) {
      ++k;
      continue;
    }
    segments[i] = joint(longer, shorter);
    segments.erase(k);
    k = i + 1;  // what was too far from the piece may be near the joint
  }
}

/// Whether the other one lies on a's active side within the trail, and a on its.
bool face_each_other(const Segment& a, const Segment& b, double trail_px,
                     double& apart_px) noexcept {
  if (a.active_is_bright != b.active_is_bright) return false;
  const BesideSegment at = beside(a, b);
  const double shorter = std::min(a.length_px(), b.length_px());
  if (!(at.common_px >= kFacingShare * shorter)) return false;
  // As they run against each other, being on a's active side is being on b's too.
  apart_px = a.active_is_bright ? at.offset_px : -at.offset_px;
  if (!(apart_px > 0.0 && apart_px <= trail_px)) return false;
  return std::abs(at.angle_rad()) >= std::numbers::pi - kFacingAngle_rad;
}

}  // namespace

void merge_collinear(Segments& segments) noexcept {
  std::sort(segments.begin(), segments.end(), is_longer);
  for (std::size_t i = 0; i < segments.size(); ++i) absorb_into(i, segments);
  std::sort(segments.begin(), segments.end(), is_longer);
}

void keep_fronts(double trail_px, Segments& segments) noexcept {
  std::array<std::size_t, limits::kMaxSegments> order;
  std::array<bool, limits::kMaxSegments> is_trail{};
  for (std::size_t i = 0; i < segments.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(segments.size()),
            [&](std::size_t a, std::size_t b) {
              return std::tuple(-segments[a].steepness, a) < std::tuple(-segments[b].steepness, b);
            });
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& front = segments[order[i]];
    if (is_trail[order[i]]) continue;  // what is no front has no trail
    for (std::size_t k = i + 1; k < segments.size(); ++k) {
      const Segment& other = segments[order[k]];
      double apart_px = 0.0;
      if (is_trail[order[k]] || !face_each_other(front, other, trail_px, apart_px)) continue;
      is_trail[order[k]] =
          apart_px <= kThinTrail_px || other.steepness <= kTrailSteepness * front.steepness;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    if (!is_trail[i]) segments[kept++] = segments[i];
  while (segments.size() > kept) segments.pop_back();
}

}  // namespace pled
