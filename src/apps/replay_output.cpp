#include "src/apps/replay_output.hpp"

namespace pled::apps {

std::string ReplayOutput::open(const std::filesystem::path& folder) {
  if (!poses_.open(folder)) return poses_.error();
  if (!features_.open(folder)) return features_.error();
  return {};
}

bool ReplayOutput::on_frame(const FrameResult& result) noexcept {
  const FrameMeasurement& frame = *result.measurement;
  const BackendOutput& backend = *result.backend;
  if (!first_frame_ns_) first_frame_ns_ = frame.stamp_ns;
  bool ok = features_.write_frame(frame, backend.weights.span());
  if (backend.has_pose) {
    const PoseEstimate& pose = result.pose_at_stamp;
    ok = poses_.write(pose).ok() && ok;
    const auto& p = pose.p_world_body_m;
    const auto& q = pose.q_world_body_xyzw;
    trajectory_.push_back({pose.stamp_ns, Pose{Eigen::Quaterniond(q[3], q[0], q[1], q[2]),
                                               Eigen::Vector3d(p[0], p[1], p[2])}});
  } else {
    last_refusal_ = to_string(backend.refusal);
  }
  progress_.update(static_cast<double>(frame.stamp_ns - *first_frame_ns_) * 1e-9,
                   backend.has_pose ? "tracking" : last_refusal_);
  return ok;
}

std::string ReplayOutput::close() {
  std::string problem;
  if (!poses_.close()) problem = poses_.error();
  if (!features_.close() && problem.empty()) problem = features_.error();
  return problem;
}

std::optional<std::int64_t> ReplayOutput::first_pose_ns() const noexcept {
  if (trajectory_.empty()) return std::nullopt;
  return trajectory_.front().stamp_ns;
}

}  // namespace pled::apps
