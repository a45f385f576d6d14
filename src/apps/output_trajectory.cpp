#include "src/apps/output_trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "src/apps/text_row.hpp"

namespace pled::apps {

Result<void> TrajectoryWriter::write(const PoseEstimate& pose) noexcept {
  constexpr int kDecimals = 9;
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(pose.p_world_body_m.begin(), pose.p_world_body_m.end(), finite) ||
      !std::all_of(pose.q_world_body_xyzw.begin(), pose.q_world_body_xyzw.end(), finite))
    return ErrorCode::kBadNumber;
  TextRow<512> row;
  row.stamp(pose.stamp_ns);
  for (const double value : pose.p_world_body_m) {
    row.text(" ");
    row.number(value, kDecimals);
  }
  for (const double value : pose.q_world_body_xyzw) {
    row.text(" ");
    row.number(value, kDecimals);
  }
  row.text("\n");
  if (!row.ok()) return ErrorCode::kBadNumber;
  if (!file_.write(row.view()) || !file_.flush()) return ErrorCode::kIoFailure;
  return {};
}

}  // namespace pled::apps
