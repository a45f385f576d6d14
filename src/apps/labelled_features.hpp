#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "drivers/replay/recording.hpp"
#include "pled_vins/config/schema.hpp"
#include "pled_vins/evaluation/weights.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/report/labels.hpp"

namespace pled::apps {

/// The weights of a feature: those of the temporal scores in the order of kTemporalScoreNames, that
/// of geometry, and the one that counts.
inline constexpr std::size_t kGeometricMode = kTemporalScoreNames.size();
inline constexpr std::size_t kFusedMode = kGeometricMode + 1;
inline constexpr auto kWeightModeNames = [] {
  std::array<std::string_view, kFusedMode + 1> names{};
  for (std::size_t k = 0; k < kGeometricMode; ++k) names[k] = kTemporalScoreNames[k].second;
  names[kGeometricMode] = "geometric";
  names[kFusedMode] = "fused";
  return names;
}();

/// Which features a figure is about.
enum class RowSet : std::uint8_t {
  kAll,     ///< all for which the weight has evidence
  kUsed,    ///< those of them that took part in the solve
  kCommon,  ///< those for which every temporal score has evidence: to compare scores on
};
inline constexpr std::array<std::pair<RowSet, std::string_view>, 3> kRowSetNames{
    {{RowSet::kAll, "all"}, {RowSet::kUsed, "used"}, {RowSet::kCommon, "common"}}};

/// One feature in one frame: what was believed of it, and what it was.
struct LabelledFeature {
  FeatureId id = 0;
  FeatureKind kind = FeatureKind::kImagePoint;
  std::uint32_t track_length = 0;
  bool is_moving = false;
  bool used = false;
  /// Where the labels were asked; of a line its middle.
  double u_px = 0.0, v_px = 0.0;
  std::array<double, kWeightModeNames.size()> w{};  ///< NaN: no evidence
};

/// Whether a line lies on something that moves: by most of the label pixels nearest to its two ends
/// and its middle. Pixels off the picture are at rest.
[[nodiscard]] bool is_line_moving(ImageView<const std::uint8_t> labels,
                                  const std::array<Eigen::Vector2d, 2>& ends_px);

/// The features of a recording's labelled frames, with their labels, as it is played.
class LabelledFeatures {
 public:
  LabelledFeatures(const replay::Recording& recording, const RigCalibration& rig);

  /// Takes the features of a frame, points first. Returns those that were added: none of a frame
  /// without labels, and none that the labels' camera would not see.
  std::span<const LabelledFeature> add(const FrameResult& result);

  [[nodiscard]] std::span<const LabelledFeature> all() const noexcept { return features_; }
  [[nodiscard]] std::size_t labelled_frames() const noexcept { return labelled_frames_; }

 private:
  void add_points(const FrameResult& result, ImageView<const std::uint8_t> labels);
  void add_lines(const FrameResult& result, ImageView<const std::uint8_t> labels);

  report::Labels labels_;
  RigCalibration rig_;
  Camera frame_camera_;
  std::vector<LabelledFeature> features_;
  std::size_t labelled_frames_ = 0;
};

/// How well one weight knows what moves.
struct WeightJudgement {
  WeightQuality quality;
  std::size_t seen = 0;         ///< features of these kinds, in the set or not
  std::size_t no_evidence = 0;  ///< of the set, of which the weight says nothing
};

/// @param mode  index into kWeightModeNames
[[nodiscard]] WeightJudgement judge_features(std::span<const LabelledFeature> features,
                                             std::span<const FeatureKind> kinds, std::size_t mode,
                                             RowSet set);

/// Whether the labels of a recording that has some can be read; prints why not.
[[nodiscard]] bool labels_can_be_read(const replay::Recording& recording);

}  // namespace pled::apps
