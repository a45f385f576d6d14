#pragma once

#include "pled_vins/evaluation/evaluate.hpp"
#include "src/report/json.hpp"
#include "src/report/rates.hpp"

namespace pled::report {

/// The trajectory laid on the truth, {"t_s", "x_m", "y_m", "z_m", "error_m"}: columns
/// of numbers, no more than can be seen. An evaluation without truth leaves it as it is.
[[nodiscard]] Json path_of_estimate(const Trajectory& trajectory, const Evaluation& evaluation,
                                    std::int64_t zero_ns);

/// The truth over the span, in the same form without errors.
[[nodiscard]] Json path_of_truth(const Trajectory& truth, PlayedSpan span);

}  // namespace pled::report
