#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "pled_vins/config/app_config.hpp"
#include "pled_vins/config/config_error.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// Cameras and IMU of a rig, with remarks that the user should see.
struct LoadedCalibration {
  RigCalibration rig;
  std::vector<std::string> notes;
};

/// The calibration of a recording: its own camchain.yaml and imu.yaml, beside it when it is
/// one file; else the files that `config` names; else the sensor.yaml files of a EuRoC `mav0`
/// folder. A camera of camchain.yaml without intrinsics takes those of calib.txt. Errors: nothing
/// found, unreadable, or a value that cannot be true (rotation not orthonormal, focal length or
/// noise not positive, principal point outside).
[[nodiscard]] std::variant<LoadedCalibration, ConfigError> load_calibration(
    const std::filesystem::path& recording, const AppConfig& config);

/// The cameras alone, found in the same places; the rig's `imu` keeps its defaults.
[[nodiscard]] std::variant<LoadedCalibration, ConfigError> load_recording_cameras(
    const std::filesystem::path& recording, const AppConfig& config);

/// The IMU part alone, found in the same places.
[[nodiscard]] std::variant<ImuNoise, ConfigError> load_recording_imu(
    const std::filesystem::path& recording, const AppConfig& config);

/// One camera with its name, as a camchain.yaml has it.
struct NamedCamera {
  std::string name;
  CameraCalibration camera;
};

/// Kalibr's camchain.yaml: cam0, cam1. `calib_txt`, when not empty, is the RPG
/// layout's calib.txt, read for a camera without intrinsics.
[[nodiscard]] std::variant<std::vector<NamedCamera>, ConfigError> load_camchain(
    const std::filesystem::path& file, const std::filesystem::path& calib_txt = {});

/// Kalibr's imu.yaml, keys at the top or under imu0; or a EuRoC imu0/sensor.yaml.
[[nodiscard]] std::variant<ImuNoise, ConfigError> load_imu_noise(const std::filesystem::path& file);

/// A EuRoC cam0/sensor.yaml.
[[nodiscard]] std::variant<CameraCalibration, ConfigError> load_euroc_camera(
    const std::filesystem::path& file);

}  // namespace pled
