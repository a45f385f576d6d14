#include "src/apps/score_rows.hpp"

#include <array>

#include "src/apps/output_features.hpp"
#include "src/apps/text_row.hpp"

namespace pled::apps {
namespace {

constexpr std::array kKinds{FeatureKind::kImagePoint, FeatureKind::kEventPoint, FeatureKind::kLine};

}  // namespace

bool ScoreRows::write_to(const std::filesystem::path& file) {
  csv_.open(file);
  csv_ << "t,id,kind,u_px,v_px,moving,used,track_length";
  for (const std::string_view name : kWeightModeNames) csv_ << ",w_" << name;
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
  for (const LabelledFeature& row : features_.add(result))
    if (csv_.is_open()) write(row, stamp_ns);
  return !csv_.is_open() || csv_.good();
}

void ScoreRows::write(const LabelledFeature& row, std::int64_t stamp_ns) {
  constexpr int kPixelDecimals = 4;
  TextRow<320> text;
  text.stamp(stamp_ns);
  text.text(",");
  text.count(row.id);
  text.text(",");
  text.text(kind_name(row.kind));
  for (const double value : {row.u_px, row.v_px}) {
    text.text(",");
    text.number(value, kPixelDecimals);
  }
  for (const std::uint64_t value :
       {std::uint64_t{row.is_moving}, std::uint64_t{row.used}, std::uint64_t{row.track_length}}) {
    text.text(",");
    text.count(value);
  }
  for (const double w : row.w) {
    text.text(",");
    text.exact_number(w);  // else others count ties where there are none
  }
  csv_ << text.view() << '\n';
}

std::vector<ScoreTable> ScoreRows::tables() const {
  std::vector<ScoreTable> out;
  for (std::size_t mode = 0; mode < kWeightModeNames.size(); ++mode) {
    for (const FeatureKind kind : kKinds) {
      for (const auto& [set, set_name] : kRowSetNames) {
        const WeightJudgement judgement =
            judge_features(features_.all(), std::array{kind}, mode, set);
        if (judgement.seen == 0) continue;
        out.push_back({kWeightModeNames[mode], kind_name(kind), set_name, judgement});
      }
    }
  }
  return out;
}

}  // namespace pled::apps
