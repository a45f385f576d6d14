#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <variant>

#include "pled_vins/backend/config.hpp"
#include "pled_vins/config/config_error.hpp"
#include "pled_vins/events/config.hpp"
#include "pled_vins/frontend/config.hpp"
#include "pled_vins/pipeline/line_config.hpp"
#include "pled_vins/reliability/config.hpp"
#include "pled_vins/reliability/motion_config.hpp"

namespace pled {

/// Which camera of the calibration serves as which sensor. A DAVIS is both in one.
struct SensorsConfig {
  std::string event_camera = "cam0";
  std::string frame_camera = "cam0";
};

/// Calibration files to use when the recording has none; empty: none. In the file
/// the keys stand at the top: `camchain: PATH`, `imu: PATH`.
struct CalibrationPaths {
  std::string camchain;  ///< Kalibr's camchain.yaml
  std::string imu;       ///< Kalibr's imu.yaml
};

/// Everything that a settings file may say.
struct AppConfig {
  FrontendConfig frontend;
  EventConfig events;
  LineStageConfig lines;
  ReliabilityConfig reliability;
  MotionCueConfig motion_cue;
  BackendConfig backend;
  SensorsConfig sensors;
  CalibrationPaths calibration;
  /// True when the file named a camera for a sensor; no key of the file.
  bool sensors_named = false;
};

/// Reads settings from a file. Keys that it leaves out keep their documented
/// defaults; relative calibration paths are taken from the file's folder. Errors:
/// missing or unreadable file, bad syntax, unknown or repeated key, wrong type,
/// value out of range, broken rule between two values.
[[nodiscard]] std::variant<AppConfig, ConfigError> load_config(const std::filesystem::path& file);

/// The same from text; `name` stands for the file in messages and paths.
[[nodiscard]] std::variant<AppConfig, ConfigError> parse_config(std::string_view text,
                                                                const std::string& name);

/// Settings as a YAML file, each key with its meaning, unit and range above it.
[[nodiscard]] std::string to_documented_yaml(const AppConfig& config);

}  // namespace pled
