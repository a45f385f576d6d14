#include "src/apps/output_features.hpp"

#include "pled_vins/core/check.hpp"
#include "src/apps/text_row.hpp"

namespace pled::apps {

std::string_view kind_name(FeatureKind kind) noexcept {
  switch (kind) {
    case FeatureKind::kImagePoint: return "image_point";
    case FeatureKind::kEventPoint: return "event_point";
    case FeatureKind::kLine: return "line";
  }
  PLED_CHECK(false);
}

bool FeaturesWriter::open(const std::filesystem::path& folder) {
  return file_.open(folder / kFileName) && file_.write(kHeader);
}

bool FeaturesWriter::write_frame(const FrameMeasurement& frame,
                                 std::span<const FeatureWeight> weights,
                                 std::span<const FeatureWeight> line_weights) noexcept {
  PLED_CHECK(weights.size() == frame.points.size());
  PLED_CHECK(line_weights.empty() || line_weights.size() == frame.lines.size());
  bool ok = true;
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    const PointMeasurement& point = frame.points[i];
    PLED_CHECK(weights[i].id == point.id);
    ok = write_row(frame.stamp_ns, kind_name(point.kind), point.raw_px, nullptr, weights[i]) && ok;
  }
  for (std::size_t i = 0; i < frame.lines.size(); ++i) {
    const LineMeasurement& line = frame.lines[i];
    const FeatureWeight unweighed{.id = line.id, .w_temporal = line.w_temporal};
    const FeatureWeight& weight = line_weights.empty() ? unweighed : line_weights[i];
    PLED_CHECK(weight.id == line.id);
    ok = write_row(frame.stamp_ns, kind_name(FeatureKind::kLine), line.raw_px[0], &line.raw_px[1],
                   weight) &&
         ok;
  }
  return file_.flush() && ok;
}

bool FeaturesWriter::write_row(std::int64_t stamp_ns, std::string_view kind,
                               const std::array<double, 2>& begin_px,
                               const std::array<double, 2>* end_px,
                               const FeatureWeight& weight) noexcept {
  constexpr int kPixelDecimals = 4;
  constexpr int kWeightDecimals = 6;
  TextRow<512> row;
  row.stamp(stamp_ns);
  row.text(",");
  row.count(weight.id);
  row.text(",");
  row.text(kind);
  for (const std::array<double, 2>* px : {&begin_px, end_px})
    for (std::size_t k = 0; k < 2; ++k) {
      row.text(",");
      if (px != nullptr) row.number((*px)[k], kPixelDecimals);  // a point has no second end
    }
  for (const double value : {weight.w_temporal, weight.w_geometric, weight.w}) {
    row.text(",");
    row.number(value, kWeightDecimals);
  }
  row.text(",");
  row.count(weight.observations);
  row.text(weight.used ? ",1\n" : ",0\n");
  return row.ok() && file_.write(row.view());
}

}  // namespace pled::apps
