#include "src/apps/labelled_features.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "src/apps/problems.hpp"

namespace pled::apps {
namespace {

/// Where something stands in the labels' picture, that of the frame camera. Of another camera it is
/// taken to be far away.
std::optional<Eigen::Vector2d> place(std::uint8_t camera, const std::array<double, 2>& raw_px,
                                     const std::array<double, 2>& bearing_xy,
                                     const RigCalibration& rig, const Camera& frame_camera) {
  if (camera == rig.frame_camera) return Eigen::Vector2d(raw_px[0], raw_px[1]);
  const Eigen::Quaterniond R =
      rig.cameras[rig.frame_camera].T_body_cam.q.conjugate() * rig.cameras[camera].T_body_cam.q;
  const auto px = frame_camera.project(R * Eigen::Vector3d(bearing_xy[0], bearing_xy[1], 1.0));
  if (!px || !frame_camera.inside(*px)) return std::nullopt;
  return px;
}

void set_weights(LabelledFeature& feature, const TemporalWeights& temporal,
                 const FeatureWeight& weight) {
  feature.used = weight.used;
  for (std::size_t k = 0; k < kGeometricMode; ++k)
    feature.w[k] = temporal.of(kTemporalScoreNames[k].first);
  feature.w[kGeometricMode] = weight.w_geometric;
  feature.w[kFusedMode] = weight.w;
}

bool belongs(const LabelledFeature& feature, RowSet set) noexcept {
  switch (set) {
    case RowSet::kUsed: return feature.used;
    case RowSet::kCommon:
      return std::none_of(feature.w.begin(), feature.w.begin() + kGeometricMode,
                          [](double w) { return std::isnan(w); });
    case RowSet::kAll: break;
  }
  return true;
}

}  // namespace

bool is_line_moving(ImageView<const std::uint8_t> labels,
                    const std::array<Eigen::Vector2d, 2>& ends_px) {
  const Eigen::Vector2d middle = 0.5 * (ends_px[0] + ends_px[1]);
  int moving = 0;
  for (const Eigen::Vector2d& px : {ends_px[0], middle, ends_px[1]})
    moving += report::is_moving(labels, px.x(), px.y()) ? 1 : 0;
  return moving >= 2;
}

LabelledFeatures::LabelledFeatures(const replay::Recording& recording, const RigCalibration& rig)
    : labels_(&recording), rig_(rig), frame_camera_(rig.cameras[rig.frame_camera]) {}

std::span<const LabelledFeature> LabelledFeatures::add(const FrameResult& result) {
  const auto labels = labels_.at(result.measurement->stamp_ns);
  if (!labels) return {};
  ++labelled_frames_;
  const std::size_t before = features_.size();
  add_points(result, *labels);
  add_lines(result, *labels);
  return std::span<const LabelledFeature>(features_).subspan(before);
}

void LabelledFeatures::add_points(const FrameResult& result, ImageView<const std::uint8_t> labels) {
  const auto& points = result.measurement->points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PointMeasurement& point = points[i];
    const auto px = place(point.camera, point.raw_px, point.bearing_xy, rig_, frame_camera_);
    if (!px) continue;
    LabelledFeature feature{.id = point.id,
                            .kind = point.kind,
                            .track_length = point.track_length,
                            .is_moving = report::is_moving(labels, px->x(), px->y()),
                            .u_px = px->x(),
                            .v_px = px->y()};
    set_weights(feature, result.temporal[i], result.backend->weights[i]);
    features_.push_back(feature);
  }
}

void LabelledFeatures::add_lines(const FrameResult& result, ImageView<const std::uint8_t> labels) {
  const auto& lines = result.measurement->lines;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const LineMeasurement& line = lines[i];
    const auto from = place(line.camera, line.raw_px[0], line.bearing_xy[0], rig_, frame_camera_);
    const auto to = place(line.camera, line.raw_px[1], line.bearing_xy[1], rig_, frame_camera_);
    if (!from || !to) continue;
    LabelledFeature feature{.id = line.id,
                            .kind = FeatureKind::kLine,
                            .track_length = line.track_length,
                            .is_moving = is_line_moving(labels, {*from, *to}),
                            .u_px = 0.5 * (from->x() + to->x()),
                            .v_px = 0.5 * (from->y() + to->y())};
    set_weights(feature, result.temporal_lines[i], result.backend->line_weights[i]);
    features_.push_back(feature);
  }
}

WeightJudgement judge_features(std::span<const LabelledFeature> features,
                               std::span<const FeatureKind> kinds, std::size_t mode, RowSet set) {
  WeightJudgement out;
  std::vector<LabelledWeight> weights;
  for (const LabelledFeature& feature : features) {
    if (std::find(kinds.begin(), kinds.end(), feature.kind) == kinds.end()) continue;
    ++out.seen;
    if (!belongs(feature, set)) continue;
    if (std::isnan(feature.w[mode])) ++out.no_evidence;
    weights.push_back({feature.w[mode], feature.is_moving});
  }
  out.quality = judge_weights(weights);
  return out;
}

bool labels_can_be_read(const replay::Recording& recording) {
  replay::Problems problems;
  const bool can_be_read = recording.open_masks(1, problems).ok();
  print_problems(problems);
  return can_be_read;
}

}  // namespace pled::apps
