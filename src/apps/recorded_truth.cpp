#include "src/apps/recorded_truth.hpp"

#include <string>

#include "src/apps/text.hpp"

namespace pled::apps {

Trajectory read_truth(const replay::Recording& recording) {
  Trajectory truth;
  replay::Problems problems;
  auto opened = recording.open_truth(problems);
  if (!opened.ok()) return truth;
  for (;;) {
    const auto state = opened.value().next();
    if (!state.ok()) {
      if (state.error().code == ErrorCode::kBadNumber) continue;
      break;
    }
    const replay::TruthState& s = state.value();
    if (!truth.empty() && s.stamp_ns <= truth.back().stamp_ns) continue;
    const auto& q = s.q_world_body_xyzw;
    truth.push_back({s.stamp_ns, Pose{Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized(),
                                      Eigen::Vector3d(s.p_world_body_m.data())}});
  }
  if (opened.value().malformed() > 0)
    print_note("the truth has " + std::to_string(opened.value().malformed()) +
               " unreadable lines, the last: " + std::string(opened.value().last_message()));
  return truth;
}

std::optional<FrameSpan> played_frames(const std::optional<FrameSpan>& whole, const RunEnd& end) {
  if (!end.first_stamp_ns || !end.last_stamp_ns) return std::nullopt;
  std::optional<FrameSpan> span = whole;
  if (!span) return std::nullopt;
  span->first_ns = *end.first_stamp_ns;
  span->last_ns = *end.last_stamp_ns;
  return span;
}

}  // namespace pled::apps
