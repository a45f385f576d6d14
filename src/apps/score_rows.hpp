#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "src/apps/labelled_features.hpp"
#include "src/apps/progress.hpp"

namespace pled::apps {

/// One line of what `score` prints.
struct ScoreTable {
  std::string_view mode;  ///< of kWeightModeNames
  std::string_view kind;  ///< of feature
  std::string_view rows;  ///< name of the row set
  WeightJudgement judgement;
};

/// Collects what each weight says of each labelled feature while a recording plays.
class ScoreRows final : public ResultSink {
 public:
  ScoreRows(const replay::Recording& recording, const RigCalibration& rig, Progress& progress)
      : features_(recording, rig), progress_(progress) {}

  /// Also writes every row to a CSV file. False when it cannot be opened.
  [[nodiscard]] bool write_to(const std::filesystem::path& file);
  bool on_frame(const FrameResult& result) noexcept override;
  /// Closes the CSV file. False when not everything could be written.
  [[nodiscard]] bool finish();

  [[nodiscard]] std::size_t labelled_frames() const noexcept { return features_.labelled_frames(); }
  /// For each weight and each kind of feature that was seen: all rows, those used, and
  /// those that every temporal score has evidence for.
  [[nodiscard]] std::vector<ScoreTable> tables() const;

 private:
  void write(const LabelledFeature& row, std::int64_t stamp_ns);

  LabelledFeatures features_;
  Progress& progress_;
  std::optional<std::int64_t> first_ns_;
  std::ofstream csv_;
};

}  // namespace pled::apps
