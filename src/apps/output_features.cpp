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
                                 std::span<const FeatureWeight> weights) noexcept {
  constexpr int kPixelDecimals = 4;
  constexpr int kWeightDecimals = 6;
  PLED_CHECK(weights.size() == frame.points.size());
  bool ok = true;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const PointMeasurement& point = frame.points[i];
    const FeatureWeight& weight = weights[i];
    PLED_CHECK(weight.id == point.id);
    TextRow<512> row;
    row.stamp(frame.stamp_ns);
    row.text(",");
    row.count(point.id);
    row.text(",");
    row.text(kind_name(point.kind));
    for (const double pixel : point.raw_px) {
      row.text(",");
      row.number(pixel, kPixelDecimals);
    }
    row.text(",,");  // a point has no second end
    for (const double value : {weight.w_temporal, weight.w_geometric, weight.w}) {
      row.text(",");
      row.number(value, kWeightDecimals);
    }
    row.text(",");
    row.count(weight.observations);
    row.text(weight.used ? ",1\n" : ",0\n");
    ok = row.ok() && file_.write(row.view()) && ok;
  }
  return file_.flush() && ok;
}

}  // namespace pled::apps
