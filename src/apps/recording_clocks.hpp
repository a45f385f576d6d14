#pragma once

#include <string>

#include "drivers/replay/recording.hpp"

namespace pled::apps {

/// Why frames and inertial data cannot be used together: a stream without a readable
/// stamp, or stamps that hardly overlap, as those of another unit or clock do. Empty when
/// all is well. `time_shift_s`: t_imu = t_cam + time_shift_s. Reads the inertial file as far
/// as it takes to see the overlap. The recording must have both streams.
[[nodiscard]] std::string clock_problem(const replay::Recording& recording, double time_shift_s);

}  // namespace pled::apps
