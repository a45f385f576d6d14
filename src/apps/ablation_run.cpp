#include "src/apps/ablation_run.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "pled_vins/backend/solvers.hpp"
#include "pled_vins/evaluation/evaluate.hpp"
#include "src/apps/recorded_truth.hpp"
#include "src/apps/run_problems.hpp"

namespace pled::apps {
namespace {

constexpr std::array kPoints{FeatureKind::kImagePoint, FeatureKind::kEventPoint};
constexpr std::array kLines{FeatureKind::kLine};

/// Keeps what a run is judged by.
class RunRecord final : public ResultSink {
 public:
  /// @param features  null: the labels are not asked
  RunRecord(LabelledFeatures* features, Progress& progress, double played_before_s,
            std::string words)
      : features_(features),
        progress_(progress),
        played_before_s_(played_before_s),
        words_(std::move(words)) {}

  bool on_frame(const FrameResult& result) noexcept override {
    const std::int64_t stamp_ns = result.measurement->stamp_ns;
    if (!first_ns_) first_ns_ = stamp_ns;
    progress_.update(played_before_s_ + static_cast<double>(stamp_ns - *first_ns_) * 1e-9, words_);
    if (features_ != nullptr) features_->add(result);
    if (!result.backend->has_pose) return true;
    const PoseEstimate& pose = result.pose_at_stamp;
    // From a clock that was set back; a trajectory only goes on.
    if (!poses_.empty() && pose.stamp_ns <= poses_.back().stamp_ns) return true;
    const auto& q = pose.q_world_body_xyzw;
    poses_.push_back({pose.stamp_ns, Pose{Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized(),
                                          Eigen::Vector3d(pose.p_world_body_m.data())}});
    return true;
  }

  [[nodiscard]] const Trajectory& poses() const noexcept { return poses_; }

 private:
  LabelledFeatures* features_;
  Progress& progress_;
  double played_before_s_;
  std::string words_;
  std::optional<std::int64_t> first_ns_;
  Trajectory poses_;
};

std::array<AblationQuality, 4> quality_of(std::span<const LabelledFeature> features) {
  const auto judge = [features](std::span<const FeatureKind> kinds, RowSet set) {
    return judge_features(features, kinds, kFusedMode, set);
  };
  return {{{"point", "all", judge(kPoints, RowSet::kAll)},
           {"point", "used", judge(kPoints, RowSet::kUsed)},
           {"line", "all", judge(kLines, RowSet::kAll)},
           {"line", "used", judge(kLines, RowSet::kUsed)}}};
}

std::string words_of(std::size_t number, const Ablation& ablation) {
  std::string words = std::to_string(number);
  words.append(" of ").append(std::to_string(kAblations.size())).append(": ");
  words.append(method_name(ablation)).append(", ").append(evidence_name(ablation));
  return words.append(", ").append(features_name(ablation));
}

}  // namespace

MedianWorst median_and_worst(std::span<const std::optional<double>> runs, bool high_is_bad) {
  std::vector<std::optional<double>> sorted(runs.begin(), runs.end());
  std::sort(sorted.begin(), sorted.end(), [high_is_bad](const auto& a, const auto& b) {
    if (!a || !b) return a.has_value() && !b.has_value();
    return high_is_bad ? *a < *b : *a > *b;
  });
  if (sorted.empty()) return {};
  const std::optional<double>& low = sorted[(sorted.size() - 1) / 2];
  const std::optional<double>& high = sorted[sorted.size() / 2];
  MedianWorst out{std::nullopt, sorted.back()};
  if (low && high) out.median = 0.5 * (*low + *high);
  return out;
}

AblationRuns::AblationRuns(OpenedRecording& opened, int starts)
    : opened_(opened),
      config_(opened.config),
      starts_(starts),
      truth_(read_truth(opened.recording)),
      progress_(Progress::on_stderr([&] {
        double all_s = 0.0;
        for (int k = 0; k < starts; ++k) all_s += length_s(k);
        return all_s * static_cast<double>(kAblations.size());
      }())) {}

double AblationRuns::length_s(int start) const {
  return std::max(0.0, opened_.whole_s - start * kAblationStartStep_s);
}

std::optional<AblationResult> AblationRuns::play(const Ablation& ablation) {
  ++configurations_;
  AblationResult result;
  result.ablation = ablation;
  opened_.config = ablated(config_, ablation);
  std::vector<std::optional<double>> ate_m, coverage;
  for (int k = 0; k < starts_; ++k) {
    opened_.options.start_s = k * kAblationStartStep_s;
    if (whole_end_ && !opened_.rewind()) return std::nullopt;
    release_estimator();
    const std::unique_ptr<WindowSolver> solver = make_solver(SolverKind::kFixed);
    const EstimatorParts parts = opened_.build(*solver);
    LabelledFeatures features(opened_.recording, opened_.rig);
    RunRecord record(k == 0 ? &features : nullptr, progress_, played_s_,
                     words_of(configurations_, ablation));
    const RunEnd end = parts.runner->run(opened_.streams.sources(), opened_.span(), record);
    played_s_ += length_s(k);
    health_ = parts.health;
    if (!whole_end_) whole_end_ = end;
    if (k == 0) result.quality = quality_of(features.all());
    const Evaluation e = evaluate(record.poses(), truth_, played_frames(opened_.observations, end));
    ate_m.push_back(e.ate_rmse_m);
    coverage.push_back(e.coverage);
  }
  result.ate_m = median_and_worst(ate_m, true);
  result.coverage = median_and_worst(coverage, false);
  return result;
}

bool AblationRuns::finish() {
  progress_.finish();
  if (health_ == nullptr) return true;
  tell_stream_faults(opened_, *health_);
  health_ = nullptr;
  release_estimator();
  return tell_failures(*whole_end_);
}

}  // namespace pled::apps
