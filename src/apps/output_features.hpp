#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "pled_vins/core/messages.hpp"
#include "src/apps/output_file.hpp"

namespace pled::apps {

/// As features.csv and `score` call it.
[[nodiscard]] std::string_view kind_name(FeatureKind kind) noexcept;

/// features.csv: one row for each feature of each processed frame, with how far it
/// was believed right after that frame's solve. Raw pixels; a cue without evidence
/// (NaN) is an empty field; points leave u1_px and v1_px empty. Lines come after the points.
class FeaturesWriter {
 public:
  static constexpr const char* kFileName = "features.csv";
  static constexpr const char* kHeader =
      "t,id,kind,u0_px,v0_px,u1_px,v1_px,w_temporal,w_geometric,w,observations,used\n";

  /// Creates the file and writes the header.
  bool open(const std::filesystem::path& folder);
  /// Writes the rows of one frame; `weights[i]` belongs to `frame.points[i]`, `line_weights[i]` to
  /// `frame.lines[i]`. Lines that nobody weighed (no `line_weights`) have their temporal weight and
  /// no other. False when the rows could not be handed to the system.
  bool write_frame(const FrameMeasurement& frame, std::span<const FeatureWeight> weights,
                   std::span<const FeatureWeight> line_weights) noexcept;
  bool close() noexcept { return file_.close(); }
  [[nodiscard]] std::string error() const { return file_.error(); }

 private:
  bool write_row(std::int64_t stamp_ns, std::string_view kind,
                 const std::array<double, 2>& begin_px, const std::array<double, 2>* end_px,
                 const FeatureWeight& weight) noexcept;

  OutputFile file_;
};

}  // namespace pled::apps
