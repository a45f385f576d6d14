#include "src/report/path_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pled::report {
namespace {

/// Points of a line on the page; more cannot be seen.
constexpr std::size_t kMaxPoints = 2500;
constexpr int kMetreDecimals = 5;

/// A pose as drawn; the error is NaN where there is no truth beside it.
struct Point {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d p_m;
  double error_m = std::numeric_limits<double>::quiet_NaN();
};

/// At most kMaxPoints: of each group of neighbours the one with the largest error, so
/// that no peak is lost. The first and the last stay.
std::vector<Point> thinned(const std::vector<Point>& points) {
  const std::size_t group = (points.size() + kMaxPoints - 1) / kMaxPoints;
  if (group <= 1) return points;
  std::vector<Point> out{points.front()};
  for (std::size_t i = 1; i + 1 < points.size(); i += group) {
    const std::size_t end = std::min(i + group, points.size() - 1);
    std::size_t worst = i;
    for (std::size_t k = i; k < end; ++k)
      if (points[k].error_m > points[worst].error_m) worst = k;
    out.push_back(points[worst]);
  }
  out.push_back(points.back());
  return out;
}

Json columns(const std::vector<Point>& all, std::int64_t zero_ns, bool with_errors) {
  Json out = {{"t_s", Json::array()},
              {"x_m", Json::array()},
              {"y_m", Json::array()},
              {"z_m", Json::array()}};
  if (with_errors) out["error_m"] = Json::array();
  for (const Point& point : thinned(all)) {
    out["t_s"].push_back(since_s(point.stamp_ns, zero_ns));
    out["x_m"].push_back(rounded(point.p_m.x(), kMetreDecimals));
    out["y_m"].push_back(rounded(point.p_m.y(), kMetreDecimals));
    out["z_m"].push_back(rounded(point.p_m.z(), kMetreDecimals));
    if (with_errors) out["error_m"].push_back(rounded(point.error_m, kMetreDecimals));
  }
  return out;
}

std::vector<Point> aligned(const Trajectory& trajectory, const Evaluation& e) {
  std::vector<Point> points;
  std::size_t next = 0;
  for (const StampedPose& pose : trajectory) {
    Point point{pose.stamp_ns, e.T_truth_estimate * pose.pose.p};
    while (next < e.position_errors.size() && e.position_errors[next].stamp_ns < pose.stamp_ns)
      ++next;
    if (next < e.position_errors.size() && e.position_errors[next].stamp_ns == pose.stamp_ns)
      point.error_m = e.position_errors[next].error_m;
    points.push_back(point);
  }
  return points;
}

}  // namespace

Json path_of_estimate(const Trajectory& trajectory, const Evaluation& e, std::int64_t zero_ns) {
  return columns(aligned(trajectory, e), zero_ns, true);
}

Json path_of_truth(const Trajectory& truth, PlayedSpan span) {
  std::vector<Point> points;
  for (const StampedPose& pose : truth)
    if (pose.stamp_ns >= span.first_ns && pose.stamp_ns <= span.last_ns)
      points.push_back({pose.stamp_ns, pose.pose.p});
  return columns(points, span.first_ns, false);
}

}  // namespace pled::report
