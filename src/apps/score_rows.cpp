#include "src/apps/score_rows.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pled_vins/config/schema.hpp"
#include "src/apps/output_features.hpp"
#include "src/apps/text_row.hpp"

namespace pled::apps {
namespace {

constexpr std::array kKinds{FeatureKind::kImagePoint, FeatureKind::kEventPoint, FeatureKind::kLine};

/// Where a point stands in the labels' picture, that of the frame camera. Of another camera it is
/// taken to be far away.
std::optional<Eigen::Vector2d> place(const PointMeasurement& point, const RigCalibration& rig,
                                     const Camera& frame_camera) {
  if (point.camera == rig.frame_camera) return Eigen::Vector2d(point.raw_px[0], point.raw_px[1]);
  const Eigen::Quaterniond R = rig.cameras[rig.frame_camera].T_body_cam.q.conjugate() *
                               rig.cameras[point.camera].T_body_cam.q;
  const auto px =
      frame_camera.project(R * Eigen::Vector3d(point.bearing_xy[0], point.bearing_xy[1], 1.0));
  if (!px || !frame_camera.inside(*px)) return std::nullopt;
  return px;
}

}  // namespace

ScoreRows::ScoreRows(const replay::Recording& recording, const RigCalibration& rig,
                     Progress& progress)
    : labels_(&recording),
      rig_(rig),
      frame_camera_(rig.cameras[rig.frame_camera]),
      progress_(progress) {}

bool ScoreRows::write_to(const std::filesystem::path& file) {
  csv_.open(file);
  csv_ << "t,id,kind,u_px,v_px,moving,used,track_length";
  for (const auto& [score, name] : kTemporalScoreNames) csv_ << ",w_" << name;
  csv_ << "\n";
  return csv_.good();
}

bool ScoreRows::finish() {
  if (!csv_.is_open()) return true;
  csv_.close();
  return !csv_.fail();
}

bool ScoreRows::on_frame(const FrameResult& result) noexcept {
  const std::int64_t stamp_ns = result.measurement->stamp_ns;
  if (!first_ns_) first_ns_ = stamp_ns;
  progress_.update(static_cast<double>(stamp_ns - *first_ns_) * 1e-9, "scoring");
  take(result);
  return !csv_.is_open() || csv_.good();
}

void ScoreRows::take(const FrameResult& result) {
  const auto labels = labels_.at(result.measurement->stamp_ns);
  if (!labels) return;
  ++labelled_frames_;
  const auto& points = result.measurement->points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PointMeasurement& point = points[i];
    const std::optional<Eigen::Vector2d> px = place(point, rig_, frame_camera_);
    if (!px) continue;
    Row row{point.kind,
            report::is_moving(*labels, px->x(), px->y()),
            result.backend->weights[i].used,
            {}};
    for (std::size_t k = 0; k < row.w.size(); ++k)
      row.w[k] = result.temporal[i].of(kTemporalScoreNames[k].first);
    rows_.push_back(row);
    if (csv_.is_open()) write(row, result.measurement->stamp_ns, point, *px);
  }
}

void ScoreRows::write(const Row& row, std::int64_t stamp_ns, const PointMeasurement& point,
                      const Eigen::Vector2d& px) {
  constexpr int kPixelDecimals = 4;
  TextRow<256> text;
  text.stamp(stamp_ns);
  text.text(",");
  text.count(point.id);
  text.text(",");
  text.text(kind_name(point.kind));
  for (const double value : {px.x(), px.y()}) {
    text.text(",");
    text.number(value, kPixelDecimals);
  }
  for (const std::uint64_t value :
       {std::uint64_t{row.is_moving}, std::uint64_t{row.used}, std::uint64_t{point.track_length}}) {
    text.text(",");
    text.count(value);
  }
  for (const double w : row.w) {
    text.text(",");
    text.exact_number(w);  // else others count ties where there are none
  }
  csv_ << text.view() << '\n';
}

bool ScoreRows::belongs(const Row& row, RowSet set) noexcept {
  const auto known = [](double w) { return !std::isnan(w); };
  switch (set) {
    case RowSet::kUsed: return row.used;
    case RowSet::kCommon: return std::all_of(row.w.begin(), row.w.end(), known);
    case RowSet::kAll: break;
  }
  return true;
}

std::vector<ScoreTable> ScoreRows::tables() const {
  std::vector<ScoreTable> out;
  for (std::size_t k = 0; k < kTemporalScoreNames.size(); ++k) {
    for (const FeatureKind kind : kKinds) {
      for (const auto& [set, set_name] : kRowSetNames) {
        ScoreTable table{std::string(kTemporalScoreNames[k].second),
                         std::string(kind_name(kind)),
                         set_name,
                         {},
                         0};
        std::vector<LabelledWeight> weights;
        std::size_t seen = 0;
        for (const Row& row : rows_) {
          if (row.kind != kind) continue;
          ++seen;
          if (!belongs(row, set)) continue;
          if (std::isnan(row.w[k])) ++table.no_evidence;
          weights.push_back({row.w[k], row.is_moving});
        }
        if (seen == 0) continue;
        table.quality = judge_weights(weights);
        out.push_back(std::move(table));
      }
    }
  }
  return out;
}

}  // namespace pled::apps
