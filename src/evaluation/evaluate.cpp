#include "pled_vins/evaluation/evaluate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pled_vins/evaluation/align.hpp"

namespace pled {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
/// Truth poses further apart say nothing about what lies between them.
constexpr std::int64_t kMaxTruthGap_ns = kNsPerS / 10;
/// Stamps are rounded to microseconds on their way; two frame periods may come out
/// this much longer.
constexpr std::int64_t kStampRounding_ns = 2'000;
constexpr std::size_t kMinMatches = 3;

/// A pose of the estimate beside the truth at its stamp.
struct Match {
  std::int64_t stamp_ns;
  Pose estimate;
  Pose truth;
};

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

std::int64_t median_period_ns(std::span<const StampedPose> poses) {
  std::vector<std::int64_t> stamps;
  stamps.reserve(poses.size());
  for (const StampedPose& pose : poses) stamps.push_back(pose.stamp_ns);
  const auto span = frame_span(stamps);
  return span ? span->period_ns : 0;
}

Pose interpolate(const StampedPose& a, const StampedPose& b, std::int64_t stamp_ns) {
  const double share =
      static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  return {a.pose.q.slerp(share, b.pose.q), a.pose.p + share * (b.pose.p - a.pose.p)};
}

/// Pairs each pose with the truth at its stamp; counts those that have none.
std::vector<Match> match(std::span<const StampedPose> estimate, std::span<const StampedPose> truth,
                         Evaluation& e) {
  std::vector<Match> matches;
  matches.reserve(estimate.size());
  std::size_t next = 0;  // first truth pose at or after the stamp
  for (const StampedPose& pose : estimate) {
    while (next < truth.size() && truth[next].stamp_ns < pose.stamp_ns) ++next;
    if (next == truth.size()) {
      ++e.outside_truth;
    } else if (truth[next].stamp_ns == pose.stamp_ns) {
      matches.push_back({pose.stamp_ns, pose.pose, truth[next].pose});
    } else if (next == 0) {
      ++e.outside_truth;
    } else if (truth[next].stamp_ns - truth[next - 1].stamp_ns > kMaxTruthGap_ns) {
      ++e.in_truth_gap;
    } else {
      matches.push_back(
          {pose.stamp_ns, pose.pose, interpolate(truth[next - 1], truth[next], pose.stamp_ns)});
    }
  }
  return matches;
}

/// Length of the truth's path from the first to the last match, their own
/// interpolated positions included.
double path_length_m(std::span<const StampedPose> truth, const std::vector<Match>& matches) {
  Eigen::Vector3d last = matches.front().truth.p;
  double length_m = 0.0;
  for (const StampedPose& pose : truth) {
    if (pose.stamp_ns <= matches.front().stamp_ns) continue;
    if (pose.stamp_ns >= matches.back().stamp_ns) break;
    length_m += (pose.pose.p - last).norm();
    last = pose.pose.p;
  }
  return length_m + (matches.back().truth.p - last).norm();
}

void absolute_errors(std::span<const StampedPose> truth, const std::vector<Match>& matches,
                     Evaluation& e) {
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  for (const Match& m : matches) {
    from.push_back(m.estimate.p);
    to.push_back(m.truth.p);
  }
  e.T_truth_estimate = align_rigid(from, to);
  double sum_m = 0.0;
  double sum_m2 = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d aligned_m = e.T_truth_estimate * from[i];
    const double error_m = (aligned_m - to[i]).norm();
    e.position_errors.push_back({matches[i].stamp_ns, aligned_m, to[i], error_m});
    sum_m += error_m;
    sum_m2 += error_m * error_m;
  }
  const auto count = static_cast<double>(matches.size());
  e.ate_rmse_m = std::sqrt(sum_m2 / count);
  e.path_m = path_length_m(truth, matches);
  e.span_s = seconds(matches.back().stamp_ns - matches.front().stamp_ns);
  if (*e.path_m > 0)
    e.mpe_percent = 100.0 * (sum_m / count) / *e.path_m;
  else
    e.notes.emplace_back("no MPE: the truth does not move");
}

void relative_errors(const std::vector<Match>& matches, std::int64_t period_ns, Evaluation& e) {
  double sum_m2 = 0.0;
  double sum_rad2 = 0.0;
  std::size_t j = 0;
  for (const Match& i : matches) {
    // h is half a period: compared doubled, so that it stays an integer.
    const auto off_ns = [&](const Match& m) { return m.stamp_ns - i.stamp_ns - kNsPerS; };
    while (j < matches.size() && 2 * off_ns(matches[j]) < -period_ns) ++j;
    if (j == matches.size()) break;
    if (2 * off_ns(matches[j]) > period_ns) continue;
    const Pose truth_step = i.truth.inverse() * matches[j].truth;
    const Pose error = truth_step.inverse() * (i.estimate.inverse() * matches[j].estimate);
    const double angle_rad = 2.0 * std::atan2(error.q.vec().norm(), std::abs(error.q.w()));
    sum_m2 += error.p.squaredNorm();
    sum_rad2 += angle_rad * angle_rad;
    ++e.rpe_pairs;
  }
  if (e.rpe_pairs == 0) {
    e.notes.emplace_back("no RPE: no two matched poses are 1 s apart");
    return;
  }
  const auto count = static_cast<double>(e.rpe_pairs);
  e.rpe_trans_m = std::sqrt(sum_m2 / count);
  e.rpe_rot_deg = std::sqrt(sum_rad2 / count) * 180.0 / std::numbers::pi;
}

void cover(std::span<const StampedPose> estimate, std::span<const StampedPose> truth,
           const FrameSpan& frames, Evaluation& e) {
  const std::int64_t first_ns = std::max(frames.first_ns, truth.front().stamp_ns);
  const std::int64_t last_ns = std::min(frames.last_ns, truth.back().stamp_ns);
  if (!(last_ns > first_ns)) {
    e.notes.emplace_back("no coverage: frames and truth do not overlap");
    return;
  }
  std::int64_t covered_ns = 0;
  for (std::size_t i = 1; i < estimate.size(); ++i) {
    const std::int64_t a_ns = estimate[i - 1].stamp_ns;
    const std::int64_t b_ns = estimate[i].stamp_ns;
    if (b_ns - a_ns > 2 * frames.period_ns + kStampRounding_ns) continue;
    covered_ns += std::max<std::int64_t>(0, std::min(b_ns, last_ns) - std::max(a_ns, first_ns));
  }
  e.coverage = static_cast<double>(covered_ns) / static_cast<double>(last_ns - first_ns);
}

}  // namespace

std::optional<FrameSpan> frame_span(std::span<const std::int64_t> stamps_ns) {
  if (stamps_ns.size() < 2) return std::nullopt;
  std::vector<std::int64_t> periods;
  periods.reserve(stamps_ns.size());
  for (std::size_t i = 1; i < stamps_ns.size(); ++i)
    periods.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return FrameSpan{stamps_ns.front(), stamps_ns.back(), *middle};
}

Evaluation evaluate(std::span<const StampedPose> estimate, std::span<const StampedPose> truth,
                    const std::optional<FrameSpan>& frames) {
  Evaluation e;
  e.poses = estimate.size();
  const std::vector<Match> matches = match(estimate, truth, e);
  e.matched = matches.size();
  const std::int64_t period_ns = median_period_ns(estimate);
  if (matches.size() >= kMinMatches) {
    absolute_errors(truth, matches, e);
    relative_errors(matches, period_ns, e);
  } else {
    e.notes.push_back("no accuracy: " + std::to_string(matches.size()) +
                      " poses have a truth beside them, 3 are needed");
  }
  if (frames && !truth.empty()) {
    cover(estimate, truth, *frames, e);
  } else if (estimate.size() >= 2 && truth.size() >= 2) {
    e.notes.emplace_back(
        "frame stamps unknown: coverage is over the overlap of trajectory and truth");
    cover(estimate, truth, {estimate.front().stamp_ns, estimate.back().stamp_ns, period_ns}, e);
  } else {
    e.notes.emplace_back("no coverage: fewer than two poses in the trajectory or the truth");
  }
  return e;
}

}  // namespace pled
