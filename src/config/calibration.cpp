#include "pled_vins/config/calibration.hpp"

#include <optional>

#include "pled_vins/config/nearest.hpp"

namespace pled {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;  // not there is an answer
  return fs::is_regular_file(path, ignored);
}

/// Where a recording has its calibration: the folder that it is, or that it lies in.
fs::path folder_of(const fs::path& recording) {
  return is_file(recording) ? recording.parent_path() : recording;
}

/// The mav0 folder of a EuRoC recording: the folder itself or one inside it.
fs::path mav0_of(const fs::path& recording) {
  std::error_code ignored;
  return fs::is_directory(recording / "mav0", ignored) ? recording / "mav0" : recording;
}

using Cameras = std::variant<std::vector<NamedCamera>, ConfigError>;

Cameras euroc_cameras(const fs::path& mav0) {
  std::vector<NamedCamera> cameras;
  for (const char* name : {"cam0", "cam1"}) {
    const fs::path file = mav0 / name / "sensor.yaml";
    if (!is_file(file)) continue;
    const auto camera = load_euroc_camera(file);
    if (const auto* error = std::get_if<ConfigError>(&camera)) return *error;
    cameras.push_back({name, std::get<CameraCalibration>(camera)});
  }
  return cameras;
}

Cameras find_cameras(const fs::path& recording, const AppConfig& config, std::string& source) {
  const fs::path folder = folder_of(recording);
  const fs::path own_calib = folder / "calib.txt";
  const fs::path calib_txt = is_file(own_calib) ? own_calib : fs::path();
  const fs::path own = folder / "camchain.yaml";
  if (is_file(own)) {
    source = own.string();
    return load_camchain(own, calib_txt);
  }
  if (!config.calibration.camchain.empty()) {
    source = config.calibration.camchain;
    return load_camchain(source, calib_txt);
  }
  const fs::path mav0 = mav0_of(recording);
  if (is_file(mav0 / "cam0/sensor.yaml")) {
    source = (mav0 / "cam0/sensor.yaml").string();
    return euroc_cameras(mav0);
  }
  const std::string how =
      "put Kalibr's camchain.yaml into the recording or name it in the settings "
      "(`camchain: PATH`)";
  if (!calib_txt.empty())
    return ConfigError{calib_txt.string(), 0, "T_cam_imu",
                       "is missing: calib.txt tells of the lens only, not where the camera sits on "
                       "the IMU; " +
                           how};
  return ConfigError{recording.string(), 0, {}, "has no camera calibration; " + how};
}

/// Index of the camera that `name` means; nullopt when there is none.
std::optional<std::uint8_t> index_of(const std::vector<NamedCamera>& cameras,
                                     const std::string& name) {
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (cameras[i].name == name) return static_cast<std::uint8_t>(i);
  return std::nullopt;
}

ConfigError no_such_camera(const std::vector<NamedCamera>& cameras, const std::string& name,
                           const char* key, const std::string& source) {
  std::vector<std::string_view> names;
  for (const NamedCamera& camera : cameras) names.push_back(camera.name);
  return {source, 0, key,
          "there is no camera '" + name + "'; the nearest is '" +
              std::string(nearest(name, names)) + "'"};
}

}  // namespace

std::variant<ImuNoise, ConfigError> load_recording_imu(const fs::path& recording,
                                                       const AppConfig& config) {
  const fs::path own = folder_of(recording) / "imu.yaml";
  if (is_file(own)) return load_imu_noise(own);
  if (!config.calibration.imu.empty()) return load_imu_noise(config.calibration.imu);
  const fs::path euroc = mav0_of(recording) / "imu0/sensor.yaml";
  if (is_file(euroc)) return load_imu_noise(euroc);
  return ConfigError{recording.string(),
                     0,
                     {},
                     "has no IMU calibration; put Kalibr's imu.yaml into the recording or name it "
                     "in the settings (`imu: PATH`)"};
}

std::variant<LoadedCalibration, ConfigError> load_recording_cameras(const fs::path& recording,
                                                                    const AppConfig& config) {
  std::string source;
  const Cameras found = find_cameras(recording, config, source);
  if (const auto* error = std::get_if<ConfigError>(&found)) return *error;
  const auto& cameras = std::get<std::vector<NamedCamera>>(found);
  LoadedCalibration out;
  for (const NamedCamera& camera : cameras) out.rig.cameras[out.rig.num_cameras++] = camera.camera;
  const auto frame = index_of(cameras, config.sensors.frame_camera);
  if (!frame)
    return no_such_camera(cameras, config.sensors.frame_camera, "sensors.frame_camera", source);
  const auto event = index_of(cameras, config.sensors.event_camera);
  if (!event)
    return no_such_camera(cameras, config.sensors.event_camera, "sensors.event_camera", source);
  out.rig.frame_camera = *frame;
  out.rig.event_camera = *event;
  if (cameras.size() > 1 && !config.sensors_named)
    out.notes.push_back(source + " has two cameras: " + cameras[*frame].name +
                        " is taken for frames and events; name others in the settings "
                        "(`sensors:`)");
  return out;
}

std::variant<LoadedCalibration, ConfigError> load_calibration(const fs::path& recording,
                                                              const AppConfig& config) {
  auto loaded = load_recording_cameras(recording, config);
  if (std::holds_alternative<ConfigError>(loaded)) return loaded;
  const auto imu = load_recording_imu(recording, config);
  if (const auto* error = std::get_if<ConfigError>(&imu)) return *error;
  std::get<LoadedCalibration>(loaded).rig.imu = std::get<ImuNoise>(imu);
  return loaded;
}

}  // namespace pled
