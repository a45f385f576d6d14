#include "src/report/feature_digest.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/report/labels.hpp"

namespace pled::report {
namespace {

/// Frames spread evenly over a run whose length nobody knows before its end: every
/// k-th is kept, and when there are too many, every second of them goes and k doubles.
class EvenSample {
 public:
  explicit EvenSample(std::size_t wanted) : wanted_(std::max<std::size_t>(wanted, 1)) {}

  void offer(Moment moment) {
    if (count_++ % stride_ != 0) return;
    kept_.push_back(std::move(moment));
    if (kept_.size() < 4 * wanted_) return;
    for (std::size_t i = 0; 2 * i < kept_.size(); ++i)
      if (i > 0) kept_[i] = std::move(kept_[2 * i]);
    kept_.resize(kept_.size() / 2);
    stride_ *= 2;
  }

  /// At most as many as wanted, the first and the last kept among them.
  std::vector<Moment> take() {
    if (kept_.size() <= wanted_) return std::move(kept_);
    std::vector<Moment> out;
    for (std::size_t i = 0; i < wanted_; ++i)
      out.push_back(std::move(
          kept_[wanted_ > 1 ? i * (kept_.size() - 1) / (wanted_ - 1) : kept_.size() / 2]));
    return out;
  }

 private:
  std::size_t wanted_;
  std::size_t stride_ = 1;
  std::size_t count_ = 0;
  std::vector<Moment> kept_;
};

/// Of a line; a point itself.
std::array<double, 2> middle_of(const FeatureRow& row) {
  if (row.kind != Kind::kLine) return row.begin_px;
  return {0.5 * (row.begin_px[0] + row.end_px[0]), 0.5 * (row.begin_px[1] + row.end_px[1])};
}

/// The upper one of two in the middle; kEmpty of none.
double median(std::vector<double> values) {
  if (values.empty()) return kEmpty;
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Puts the rows of one frame at a time into the figures.
class Digester {
 public:
  Digester(const replay::Recording* recording, std::size_t max_moments)
      : labels_(recording),
        events_are_labelled_(recording == nullptr || same_sensor(*recording)),
        sample_(max_moments) {}

  void add(const FeatureRow& row) {
    if (frame_.rows.empty() || row.stamp_ns != frame_.stamp_ns) {
      finish_frame();
      frame_.stamp_ns = row.stamp_ns;
    }
    frame_.rows.push_back({row, false});
  }

  FeatureDigest finish() {
    finish_frame();
    digest_.moments = sample_.take();
    return std::move(digest_);
  }

 private:
  void finish_frame() {
    if (frame_.rows.empty()) return;
    const auto labels = labels_.at(frame_.stamp_ns);
    const auto has_label = [&](const FeatureRow& row) {
      return labels && (events_are_labelled_ || !is_of_events(row));
    };
    FrameStats stats;
    stats.stamp_ns = frame_.stamp_ns;
    double sum_w = 0.0;
    int weighed = 0;
    for (auto& [row, moving] : frame_.rows) {
      const auto [u_px, v_px] = middle_of(row);
      moving = has_label(row) && is_moving(*labels, u_px, v_px);
      ++stats.tracked[static_cast<std::size_t>(row.kind)];
      stats.used += row.used ? 1 : 0;
      stats.event_points_used += row.used && row.kind == Kind::kEventPoint ? 1 : 0;
      stats.moving += moving ? 1 : 0;
      if (!std::isnan(row.w)) {
        sum_w += row.w;
        ++weighed;
      }
      if (labels && !has_label(row)) continue;
      digest_.w.add(row.w, moving);
      digest_.w_temporal.add(row.w_temporal, moving);
      digest_.w_geometric.add(row.w_geometric, moving);
    }
    digest_.labelled = digest_.labelled || labels.has_value();
    if (weighed > 0) stats.mean_w = sum_w / weighed;
    stats.image_points = temporal_of(Kind::kImagePoint);
    stats.event_points = temporal_of(Kind::kEventPoint);
    digest_.frames.push_back(stats);
    sample_.offer(std::exchange(frame_, {}));
  }

  [[nodiscard]] FrameStats::Temporal temporal_of(Kind kind) const {
    std::vector<double> still, moving;
    for (const LabelledRow& r : frame_.rows)
      if (r.row.kind == kind && !std::isnan(r.row.w_temporal))
        (r.moving ? moving : still).push_back(r.row.w_temporal);
    return {median(std::move(still)), median(std::move(moving))};
  }

  Labels labels_;
  bool events_are_labelled_;
  EvenSample sample_;
  Moment frame_;
  FeatureDigest digest_;
};

}  // namespace

void Histogram::add(double weight, bool is_moving) {
  if (std::isnan(weight)) return;
  const double scaled = std::clamp(weight, 0.0, 1.0) * static_cast<double>(kBins);
  const std::size_t bin = std::min(static_cast<std::size_t>(scaled), kBins - 1);
  ++(is_moving ? moving : still)[bin];
}

bool same_sensor(const replay::Recording& recording) {
  return recording.event_size() == recording.frame_size();
}

bool Histogram::empty() const {
  const auto nothing = [](std::uint64_t count) { return count == 0; };
  return std::all_of(still.begin(), still.end(), nothing) &&
         std::all_of(moving.begin(), moving.end(), nothing);
}

std::variant<FeatureDigest, FileError> digest_features(const std::filesystem::path& file,
                                                       const replay::Recording* recording,
                                                       std::size_t max_moments) {
  FeaturesFile rows(file);
  Digester digester(recording, max_moments);
  while (const auto row = rows.next()) digester.add(*row);
  if (rows.error()) return *rows.error();
  return digester.finish();
}

}  // namespace pled::report
