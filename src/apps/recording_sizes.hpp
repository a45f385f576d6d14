#pragma once

#include <string>

#include "drivers/replay/recording.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled::apps {

/// Tells the recording how large its sensors are by their calibration: the frames' size,
/// and the event sensor's where no RAW header says it. Returns what cannot be true, in
/// words; empty when all agree. Where the frames disagree the recording is left as it is.
[[nodiscard]] std::string apply_calibrated_sizes(replay::Recording& recording,
                                                 const RigCalibration& rig);

/// The smallest class with storage in this build that holds the recording's sensors; null,
/// with words in `problem`, when none does.
[[nodiscard]] const limits::SensorClass* sensor_class(const replay::Recording& recording,
                                                      std::string& problem);

}  // namespace pled::apps
