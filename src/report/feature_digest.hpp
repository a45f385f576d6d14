#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <variant>
#include <vector>

#include "drivers/replay/recording.hpp"
#include "src/report/features_file.hpp"

namespace pled::report {

/// What one frame's features come to.
struct FrameStats {
  std::int64_t stamp_ns = 0;
  std::array<int, static_cast<std::size_t>(Kind::kCount)> tracked{};  ///< by kind
  int used = 0;
  int event_points_used = 0;
  int moving = 0;          ///< on something that moves, where there are labels
  double mean_w = kEmpty;  ///< over those that have a weight
  /// Median temporal weight of the points of a kind: at rest or unlabelled, and moving ones.
  struct Temporal {
    double still = kEmpty;
    double moving = kEmpty;
  };
  Temporal image_points, event_points;
};

struct LabelledRow {
  FeatureRow row;
  bool moving = false;
};

/// Whether events and frames come from the pixels of one sensor, as far as sizes tell: then they
/// share the labels and one picture.
[[nodiscard]] bool same_sensor(const replay::Recording& recording);

/// A frame whose features are kept one by one, to be drawn.
struct Moment {
  std::int64_t stamp_ns = 0;
  std::vector<LabelledRow> rows;
};

/// How often each weight occurs: 20 bins over 0 ... 1.
struct Histogram {
  static constexpr std::size_t kBins = 20;
  std::array<std::uint64_t, kBins> still{};
  std::array<std::uint64_t, kBins> moving{};

  void add(double weight, bool is_moving);
  [[nodiscard]] bool empty() const;
};

/// features.csv in figures: a line for each frame, histograms over all, and some
/// frames whole.
struct FeatureDigest {
  std::vector<FrameStats> frames;
  Histogram w, w_temporal, w_geometric;
  std::vector<Moment> moments;
  bool labelled = false;  ///< moving and still features were told apart
};

/// Reads the file once. `recording` lends its labels and may be null; a line has that of its
/// middle. What events of another sensor show has no label: where others have one, it is left out
/// of the histograms.
[[nodiscard]] std::variant<FeatureDigest, FileError> digest_features(
    const std::filesystem::path& file, const replay::Recording* recording, std::size_t max_moments);

}  // namespace pled::report
