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
  bool ok = features_.write_frame(frame, backend.weights.span(), backend.line_weights.span());
  count(frame);
  if (backend.pose.reset_counter != resets_) {
    resets_ = backend.pose.reset_counter;
    resets_ns_.push_back(frame.stamp_ns);
  }
  if (backend.has_pose) {
    const PoseEstimate& pose = result.pose_at_stamp;
    ok = poses_.write(pose).ok() && ok;
    if (!first_pose_ns_) first_pose_ns_ = pose.stamp_ns;
    ++poses_written_;
  } else {
    last_refusal_ = to_string(backend.refusal);
  }
  progress_.update(static_cast<double>(frame.stamp_ns - *first_frame_ns_) * 1e-9,
                   backend.has_pose ? "tracking" : last_refusal_);
  return ok;
}

void ReplayOutput::count(const FrameMeasurement& frame) noexcept {
  ++frames_;
  for (const PointMeasurement& point : frame.points)
    ++features_seen_[static_cast<std::size_t>(point.kind)];
  features_seen_[static_cast<std::size_t>(FeatureKind::kLine)] += frame.lines.size();
}

std::optional<double> ReplayOutput::features_per_frame(FeatureKind kind) const noexcept {
  if (frames_ == 0) return std::nullopt;
  return static_cast<double>(features_seen_[static_cast<std::size_t>(kind)]) /
         static_cast<double>(frames_);
}

std::string ReplayOutput::close() {
  std::string problem;
  if (!poses_.close()) problem = poses_.error();
  if (!features_.close() && problem.empty()) problem = features_.error();
  return problem;
}

}  // namespace pled::apps
