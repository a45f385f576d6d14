#include "src/apps/recording_sizes.hpp"

#include <algorithm>

#include "src/apps/estimator_storage.hpp"

namespace pled::apps {
namespace {

using replay::ImageSize;

std::string text_of(ImageSize size) {
  return std::to_string(size.width_px) + "x" + std::to_string(size.height_px);
}

std::string contradiction(const std::string& what, const char* camera, ImageSize calibrated) {
  return what + " pixels but the calibration of the " + camera + " camera says " +
         text_of(calibrated) +
         ": correct 'resolution' in camchain.yaml or name the right camera in sensors." + camera +
         "_camera";
}

}  // namespace

std::string apply_calibrated_sizes(replay::Recording& recording, const RigCalibration& rig) {
  const CameraCalibration& frames = rig.cameras[rig.frame_camera];
  const ImageSize frame_size{frames.width_px, frames.height_px};
  if (recording.has(replay::Stream::kFrames) && !recording.set_frame_size(frame_size))
    return contradiction("the frames have " + text_of(recording.frame_size()), "frame", frame_size);
  if (!recording.has(replay::Stream::kEvents)) return {};
  const CameraCalibration& events = rig.cameras[rig.event_camera];
  const ImageSize event_size{events.width_px, events.height_px};
  const ImageSize told = recording.event_size();
  if (told != ImageSize{} && told != event_size)
    return contradiction("the header of " + recording.files().events + " says " + text_of(told),
                         "event", event_size);
  recording.set_event_size(event_size);
  return {};
}

const limits::SensorClass* sensor_class(const replay::Recording& recording, std::string& problem) {
  const ImageSize frames = recording.frame_size();
  const ImageSize events = recording.event_size();
  const ImageSize both{std::max(frames.width_px, events.width_px),
                       std::max(frames.height_px, events.height_px)};
  const limits::SensorClass* sensor = smallest_class(both.width_px, both.height_px);
  if (sensor == nullptr) {
    const limits::SensorClass& largest = limits::kSensorClasses.back();
    problem = "the recording's sensor has " + text_of(both) + " pixels; the largest class is " +
              std::string(largest.name) + " (" + text_of({largest.width_px, largest.height_px}) +
              "): scale the recording down";
    return nullptr;
  }
  if (has_storage(*sensor)) return sensor;
  for (const limits::SensorClass& other : limits::kSensorClasses)
    if (has_storage(other) && both.width_px <= other.width_px && both.height_px <= other.height_px)
      return &other;
  problem = "the recording's sensor has " + text_of(both) +
            " pixels; this build has no memory for it: build with -DPLED_SENSOR=" +
            std::string(sensor->name);
  return nullptr;
}

}  // namespace pled::apps
