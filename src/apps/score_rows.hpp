#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/replay/recording.hpp"
#include "pled_vins/evaluation/weights.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/apps/progress.hpp"
#include "src/report/labels.hpp"

namespace pled::apps {

/// Which points a table is about.
enum class RowSet : std::uint8_t {
  kAll,     ///< all for which the score has evidence
  kUsed,    ///< those of them that took part in the solve
  kCommon,  ///< those for which every score has evidence: to compare scores on
};
inline constexpr std::array<std::pair<RowSet, std::string_view>, 3> kRowSetNames{
    {{RowSet::kAll, "all"}, {RowSet::kUsed, "used"}, {RowSet::kCommon, "common"}}};

/// One line of what `score` prints.
struct ScoreTable {
  std::string mode;       ///< the temporal score
  std::string kind;       ///< of feature
  std::string_view rows;  ///< name of the row set
  WeightQuality quality;
  std::size_t no_evidence = 0;  ///< rows about which the score says nothing; not in `quality`
};

/// Collects what each temporal score says of each labelled point while a recording plays.
class ScoreRows final : public ResultSink {
 public:
  ScoreRows(const replay::Recording& recording, const RigCalibration& rig, Progress& progress);

  /// Also writes every row to a CSV file. False when it cannot be opened.
  [[nodiscard]] bool write_to(const std::filesystem::path& file);
  bool on_frame(const FrameResult& result) noexcept override;
  /// Closes the CSV file. False when not everything could be written.
  [[nodiscard]] bool finish();

  [[nodiscard]] std::size_t labelled_frames() const noexcept { return labelled_frames_; }
  /// For each score and each kind of feature that was seen: all rows, those used, and
  /// those that every score has evidence for.
  [[nodiscard]] std::vector<ScoreTable> tables() const;

 private:
  struct Row {
    FeatureKind kind;
    bool is_moving;
    bool used;
    std::array<double, 3> w;  ///< in the order of kTemporalScoreNames
  };

  [[nodiscard]] static bool belongs(const Row& row, RowSet set) noexcept;
  void take(const FrameResult& result);
  void write(const Row& row, std::int64_t stamp_ns, const PointMeasurement& point,
             const Eigen::Vector2d& px);

  report::Labels labels_;
  RigCalibration rig_;
  Camera frame_camera_;
  Progress& progress_;
  std::vector<Row> rows_;
  std::size_t labelled_frames_ = 0;
  std::optional<std::int64_t> first_ns_;
  std::ofstream csv_;
};

}  // namespace pled::apps
