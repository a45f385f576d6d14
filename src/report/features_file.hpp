#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/evaluation/trajectory.hpp"

namespace pled::report {

/// A cue without evidence, and the second end of a point.
inline constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();

enum class Kind : std::uint8_t { kImagePoint, kEventPoint, kLine, kCount };

/// A row of features.csv.
struct FeatureRow {
  std::int64_t stamp_ns = 0;
  std::uint64_t id = 0;
  Kind kind = Kind::kImagePoint;
  std::array<double, 2> begin_px{};
  std::array<double, 2> end_px{kEmpty, kEmpty};
  double w_temporal = kEmpty;
  double w_geometric = kEmpty;
  double w = kEmpty;
  int observations = 0;
  bool used = false;
};

/// Whether events showed it: their points and lines have ids of their own.
[[nodiscard]] inline bool is_of_events(const FeatureRow& row) noexcept {
  return row.kind == Kind::kEventPoint || (row.kind == Kind::kLine && row.id >= kFirstEventLineId);
}

/// features.csv row by row, so that its length costs no memory.
class FeaturesFile {
 public:
  explicit FeaturesFile(const std::filesystem::path& file);

  /// The next row; nothing at the end or when something is wrong.
  [[nodiscard]] std::optional<FeatureRow> next();
  /// What is wrong: no such file, a line that does not read, a stamp that goes back, a
  /// last line without its end (the file was cut).
  [[nodiscard]] const std::optional<FileError>& error() const noexcept { return error_; }

 private:
  void fail(std::string text) { error_ = FileError{name_, line_, std::move(text)}; }
  [[nodiscard]] bool read_line();

  std::string name_;
  std::ifstream stream_;
  std::string text_;
  std::int64_t line_ = 0;
  std::optional<std::int64_t> last_stamp_ns_;
  std::optional<FileError> error_;
};

}  // namespace pled::report
