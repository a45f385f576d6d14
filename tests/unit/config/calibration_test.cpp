#include "pled_vins/config/calibration.hpp"

#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "unit/config/text_file.hpp"

namespace {

using pled::ConfigError;
using pled::support::ScratchFolder;
using pled::support::TextFile;

/// A camera turned 90 degrees about x, 0.1 m along the IMU's y.
const std::string kTransform =
    "  T_cam_imu:\n"
    "  - [1.0, 0.0, 0.0, 0.01]\n"
    "  - [0.0, 0.0, -1.0, 0.02]\n"
    "  - [0.0, 1.0, 0.0, -0.1]\n"
    "  - [0.0, 0.0, 0.0, 1.0]\n";

std::string camera(const std::string& name, const std::string& transform = kTransform) {
  return name +
         ":\n"
         "  camera_model: pinhole\n"
         "  intrinsics: [200.5, 201.5, 120.25, 90.75]\n"
         "  distortion_model: radtan\n"
         "  distortion_coeffs: [-0.3, 0.1, 0.001, -0.002]\n" +
         transform +
         "  timeshift_cam_imu: 0.004\n"
         "  resolution: [240, 180]\n"
         "  cam_overlaps: [1]\n"
         "  rostopic: /cam\n";
}

const std::string kImu =
    "accelerometer_noise_density: 0.02\n"
    "accelerometer_random_walk: 0.0003\n"
    "gyroscope_noise_density: 0.001\n"
    "gyroscope_random_walk: 1.5e-05\n"
    "rostopic: /imu0\n"
    "update_rate: 400.0\n";

ConfigError camchain_error(const std::string& text) {
  const TextFile file("camchain.yaml", text);
  const auto read = pled::load_camchain(file.path());
  REQUIRE(std::holds_alternative<ConfigError>(read));
  return std::get<ConfigError>(read);
}

std::vector<pled::NamedCamera> camchain(const std::string& text) {
  const TextFile file("camchain.yaml", text);
  const auto read = pled::load_camchain(file.path());
  if (const auto* error = std::get_if<ConfigError>(&read)) FAIL(error->message());
  return std::get<std::vector<pled::NamedCamera>>(read);
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

pled::LoadedCalibration load(const ScratchFolder& folder, const pled::AppConfig& config = {}) {
  const auto read = pled::load_calibration(folder.path(), config);
  if (const auto* error = std::get_if<ConfigError>(&read)) FAIL(error->message());
  return std::get<pled::LoadedCalibration>(read);
}

TEST_SUITE("config.calibration") {
  TEST_CASE("a camchain gives lens, size, time shift and the inverse of T_cam_imu") {
    const auto cameras = camchain(camera("cam0"));
    REQUIRE(cameras.size() == 1);
    const pled::CameraCalibration& c = cameras[0].camera;
    CHECK(cameras[0].name == "cam0");
    CHECK(c.width_px == 240);
    CHECK(c.height_px == 180);
    CHECK(c.fx_px == 200.5);
    CHECK(c.fy_px == 201.5);
    CHECK(c.cx_px == 120.25);
    CHECK(c.cy_px == 90.75);
    CHECK(c.distortion == pled::Distortion::kRadtan);
    CHECK(c.coeffs == std::array<double, 5>{-0.3, 0.1, 0.001, -0.002, 0.0});
    CHECK(c.time_shift_s == 0.004);
    // p_cam = R p_imu + t with R = Rot_x(90 deg): the point p_imu = (1, 2, 3) is at
    // (1 + 0.01, -3 + 0.02, 2 - 0.1), and T_body_cam takes it back.
    CHECK((c.T_body_cam * Eigen::Vector3d(1.01, -2.98, 1.9) - Eigen::Vector3d(1, 2, 3)).norm() <
          1e-12);
  }

  TEST_CASE("every distortion model that we have is read, others are refused by name") {
    const std::string text = camera("cam0");
    CHECK(camchain(replaced(text, "radtan", "equidistant"))[0].camera.distortion ==
          pled::Distortion::kEquidistant);
    const auto none = camchain(replaced(replaced(text, "radtan", "none"),
                                        "  distortion_coeffs: [-0.3, 0.1, 0.001, -0.002]\n", ""));
    CHECK(none[0].camera.distortion == pled::Distortion::kNone);
    CHECK(none[0].camera.coeffs == std::array<double, 5>{});
    CHECK(camchain(replaced(text, "-0.002]", "-0.002, 0.05]"))[0].camera.coeffs[4] == 0.05);
    const ConfigError fov = camchain_error(replaced(text, "radtan", "fov"));
    CHECK(fov.key == "cam0.distortion_model");
    CHECK(fov.line == 4);
    CHECK(camchain_error(replaced(text, "pinhole", "omni")).key == "cam0.camera_model");
  }

  TEST_CASE("a rotation with few digits is made orthonormal, a wrong one is refused") {
    const std::string text = camera("cam0");
    const auto rounded =
        camchain(replaced(text, "[1.0, 0.0, 0.0, 0.01]", "[1.0004, 0.0003, 0.0, 0.01]"));
    CHECK(std::abs(rounded[0].camera.T_body_cam.q.norm() - 1.0) < 1e-12);
    const ConfigError scaled =
        camchain_error(replaced(text, "[1.0, 0.0, 0.0, 0.01]", "[1.01, 0, 0, 0]"));
    CHECK(scaled.key == "cam0.T_cam_imu");
    CHECK(scaled.line == 7);
    CHECK(scaled.text.find("orthonormal") != std::string::npos);
    CHECK(camchain_error(replaced(text, "[1.0, 0.0, 0.0, 0.01]", "[-1.0, 0, 0, 0]"))
              .text.find("mirrors") != std::string::npos);
    CHECK(camchain_error(replaced(text, "[0.0, 0.0, 0.0, 1.0]", "[0, 0, 0.1, 1]"))
              .text.find("last row") != std::string::npos);
    CHECK(camchain_error(replaced(text, "[0.0, 0.0, 0.0, 1.0]", "[0, 0, 1]")).key ==
          "cam0.T_cam_imu");
  }

  TEST_CASE("figures that no camera can have are refused with their line") {
    const std::string text = camera("cam0");
    CHECK(camchain_error(replaced(text, "200.5", "-200.5")).text.find("focal") !=
          std::string::npos);
    CHECK(camchain_error(replaced(text, "120.25", "240.5")).text.find("principal point") !=
          std::string::npos);
    CHECK(camchain_error(replaced(text, "[240, 180]", "[240, 0]")).key == "cam0.resolution");
    CHECK(camchain_error(replaced(text, "[240, 180]", "[240.5, 180]")).key == "cam0.resolution");
    const ConfigError nan = camchain_error(replaced(text, "200.5", ".nan"));
    CHECK(nan.key == "cam0.intrinsics");
    CHECK(nan.line == 3);
    CHECK(camchain_error(replaced(text, "  resolution: [240, 180]\n", "")).text == "is missing");
    CHECK(camchain_error(replaced(text, "  distortion_coeffs: [-0.3, 0.1, 0.001, -0.002]\n", ""))
              .key == "cam0.distortion_coeffs");
    CHECK(camchain_error(camera("cam0", "")).key == "cam0.T_cam_imu");
    CHECK(camchain_error("cam0: [1, 2\n").text.find("YAML") != std::string::npos);
    CHECK(camchain_error("rig: none\n").key == "cam0");
    CHECK(camchain_error("").text.find("no cameras") != std::string::npos);
    CHECK(camchain_error(text + camera("cam0")).text.find("second time") != std::string::npos);
    CHECK(camchain_error(text + camera("cam1") + camera("cam2")).key == "cam2");
  }

  TEST_CASE("a time shift beyond a second is refused with its line and range") {
    const std::string text = camera("cam0");
    CHECK(camchain(replaced(text, "0.004", "-1"))[0].camera.time_shift_s == -1.0);
    for (const char* wrong : {"5", "-1.001", "1e12", "1e15"}) {
      const ConfigError e = camchain_error(replaced(text, "0.004", wrong));
      CHECK(e.key == "cam0.timeshift_cam_imu");
      CHECK(e.line == 11);
      CHECK(e.text.find(wrong) != std::string::npos);
      CHECK(e.text.find("[-1, 1] s") != std::string::npos);
    }
  }

  TEST_CASE("absurd figures are refused with the range that they must lie in") {
    struct Case {
      const char* from;
      const char* to;
      const char* words;
    };
    for (const Case& c : {Case{"-0.3,", "1e9,", "[-1000, 1000]"},
                          {"0.02]", "1e9]", "[-100, 100] m"},
                          {"200.5", "1e300", "[1, 1e+05] px"},
                          {"[240, 180]", "[240, 100000]", "[1, 4096] px"}}) {
      CAPTURE(c.to);
      const ConfigError e = camchain_error(replaced(camera("cam0"), c.from, c.to));
      CHECK_MESSAGE(e.text.find(c.words) != std::string::npos, e.message());
      CHECK(e.line > 1);
    }
    for (const char* wrong : {"1e300", "1e-300"}) {
      const TextFile file("imu.yaml", replaced(kImu, "0.02", wrong));
      const auto read = pled::load_imu_noise(file.path());
      REQUIRE(std::holds_alternative<ConfigError>(read));
      CHECK(std::get<ConfigError>(read).text.find("[1e-09, 100]") != std::string::npos);
    }
  }

  TEST_CASE("a transform of three rows is told what it lacks") {
    const ConfigError e =
        camchain_error(replaced(camera("cam0"), "  - [0.0, 0.0, 0.0, 1.0]\n", ""));
    CHECK(e.key == "cam0.T_cam_imu");
    CHECK_MESSAGE(e.text.find("3 rows: must be 4 rows of 4") != std::string::npos, e.message());
  }

  TEST_CASE("a key that stands twice in a camera or an IMU is refused") {
    const ConfigError e = camchain_error(camera("cam0") + "  resolution: [346, 260]\n");
    CHECK(e.key == "cam0.resolution");
    CHECK(e.text.find("second time") != std::string::npos);
    const TextFile file("imu.yaml", kImu + "update_rate: 200\n");
    const auto read = pled::load_imu_noise(file.path());
    REQUIRE(std::holds_alternative<ConfigError>(read));
    CHECK(std::get<ConfigError>(read).key == "update_rate");
  }

  TEST_CASE("a second camera without T_cam_imu is chained from the first") {
    const std::string chained =
        "  T_cn_cnm1:\n"
        "  - [1.0, 0.0, 0.0, -0.06]\n"
        "  - [0.0, 1.0, 0.0, 0.0]\n"
        "  - [0.0, 0.0, 1.0, 0.0]\n"
        "  - [0.0, 0.0, 0.0, 1.0]\n";
    const auto cameras = camchain(camera("cam0") + camera("cam1", chained));
    REQUIRE(cameras.size() == 2);
    const Eigen::Vector3d p_imu(1, 2, 3);
    const Eigen::Vector3d p_cam0 = cameras[0].camera.T_body_cam.inverse() * p_imu;
    const Eigen::Vector3d p_cam1 = cameras[1].camera.T_body_cam.inverse() * p_imu;
    CHECK((p_cam1 - (p_cam0 + Eigen::Vector3d(-0.06, 0, 0))).norm() < 1e-12);
  }

  TEST_CASE("an imu.yaml is read at the top and under imu0; noise must be positive") {
    const TextFile top("imu.yaml", kImu);
    std::string nested = "imu0:\n";
    for (std::size_t at = 0; at < kImu.size();) {
      const std::size_t end = kImu.find('\n', at);
      nested += "  " + kImu.substr(at, end - at) + "\n";
      at = end + 1;
    }
    const TextFile under("imu.yaml", nested);
    for (const TextFile* file : {&top, &under}) {
      const auto read = pled::load_imu_noise(file->path());
      REQUIRE(std::holds_alternative<pled::ImuNoise>(read));
      const auto& noise = std::get<pled::ImuNoise>(read);
      CHECK(noise.accel_density == 0.02);
      CHECK(noise.accel_walk == 0.0003);
      CHECK(noise.gyro_density == 0.001);
      CHECK(noise.gyro_walk == 1.5e-5);
      CHECK(noise.rate_hz == 400.0);
    }
    for (const char* wrong : {"0", "-0.001", ".nan", "small"}) {
      const TextFile file("imu.yaml", replaced(kImu, "0.001", wrong));
      const auto read = pled::load_imu_noise(file.path());
      REQUIRE(std::holds_alternative<ConfigError>(read));
      CHECK(std::get<ConfigError>(read).key == "gyroscope_noise_density");
      CHECK(std::get<ConfigError>(read).line == 3);
    }
    const TextFile short_file("imu.yaml", replaced(kImu, "update_rate: 400.0\n", ""));
    const auto read = pled::load_imu_noise(short_file.path());
    REQUIRE(std::holds_alternative<ConfigError>(read));
    CHECK(std::get<ConfigError>(read).key == "update_rate");
  }

  TEST_CASE("the recording's own files win over those of the settings") {
    const ScratchFolder folder;
    folder.write("camchain.yaml", camera("cam0"));
    folder.write("imu.yaml", kImu);
    const ScratchFolder other;
    pled::AppConfig config;
    config.calibration.camchain =
        other.write("c.yaml", replaced(camera("cam0"), "200.5", "300")).string();
    config.calibration.imu = other.write("i.yaml", replaced(kImu, "400.0", "1000")).string();
    CHECK(load(folder, config).rig.cameras[0].fx_px == 200.5);
    CHECK(load(folder, config).rig.imu.rate_hz == 400.0);
    const ScratchFolder bare;
    CHECK(load(bare, config).rig.cameras[0].fx_px == 300.0);
    CHECK(load(bare, config).rig.imu.rate_hz == 1000.0);
  }

  TEST_CASE("the calibration of a recording that is one file lies beside it") {
    const ScratchFolder folder;
    folder.write("walk.aedat4", "#!AER-DAT4.0");
    folder.write("camchain.yaml", camera("cam0"));
    folder.write("imu.yaml", kImu);
    CHECK(std::holds_alternative<pled::LoadedCalibration>(
        pled::load_calibration(folder.path() / "walk.aedat4", {})));
  }

  TEST_CASE("nothing found is an error that says what to do") {
    const ScratchFolder folder;
    const auto none = pled::load_calibration(folder.path(), {});
    REQUIRE(std::holds_alternative<ConfigError>(none));
    CHECK(std::get<ConfigError>(none).text.find("camchain.yaml") != std::string::npos);
    folder.write("camchain.yaml", camera("cam0"));
    const auto no_imu = pled::load_calibration(folder.path(), {});
    REQUIRE(std::holds_alternative<ConfigError>(no_imu));
    CHECK(std::get<ConfigError>(no_imu).text.find("imu.yaml") != std::string::npos);
  }

  TEST_CASE("calib.txt alone is not enough and says that T_cam_imu is missing") {
    const ScratchFolder folder;
    folder.write("calib.txt", "199 198 132 110 -0.3 0.1 0 0 0.02\n");
    folder.write("imu.yaml", kImu);
    const auto read = pled::load_calibration(folder.path(), {});
    REQUIRE(std::holds_alternative<ConfigError>(read));
    CHECK(std::get<ConfigError>(read).key == "T_cam_imu");
    // With a camchain that has no lens, the lens is calib.txt's.
    folder.write("camchain.yaml",
                 replaced(camera("cam0"), "  intrinsics: [200.5, 201.5, 120.25, 90.75]\n", ""));
    const pled::CameraCalibration c = load(folder).rig.cameras[0];
    CHECK(c.fx_px == 199.0);
    CHECK(c.coeffs[4] == 0.02);
    folder.write("calib.txt", "199 198 132 oops\n");
    const auto text = pled::load_calibration(folder.path(), {});
    REQUIRE(std::holds_alternative<ConfigError>(text));
    CHECK(std::get<ConfigError>(text).text.find("'oops'") != std::string::npos);
  }

  TEST_CASE("the settings say which camera is which; unsaid with two, a note does") {
    const ScratchFolder folder;
    folder.write("camchain.yaml",
                 camera("cam0") + replaced(camera("cam1"), "[240, 180]", "[346, 260]"));
    folder.write("imu.yaml", kImu);
    const pled::LoadedCalibration unsaid = load(folder);
    CHECK(unsaid.rig.num_cameras == 2);
    CHECK(unsaid.rig.frame_camera == 0);
    CHECK(unsaid.rig.event_camera == 0);
    REQUIRE(unsaid.notes.size() == 1);
    CHECK(unsaid.notes[0].find("two cameras") != std::string::npos);
    const auto parsed = pled::parse_config("sensors: {event_camera: cam1}\n", "c.yaml");
    const pled::LoadedCalibration said = load(folder, std::get<pled::AppConfig>(parsed));
    CHECK(said.rig.event_camera == 1);
    CHECK(said.rig.cameras[said.rig.event_camera].width_px == 346);
    CHECK(said.rig.frame_camera == 0);
    CHECK(said.notes.empty());
    pled::AppConfig wrong;
    wrong.sensors.frame_camera = "cam3";
    const auto read = pled::load_calibration(folder.path(), wrong);
    REQUIRE(std::holds_alternative<ConfigError>(read));
    CHECK(std::get<ConfigError>(read).key == "sensors.frame_camera");
  }

  TEST_CASE("a EuRoC folder brings its own sensor.yaml, where T_BS is T_body_cam") {
    const ScratchFolder folder;
    folder.write("mav0/cam0/sensor.yaml",
                 "%YAML:1.0\n"
                 "sensor_type: camera\n"
                 "T_BS:\n  cols: 4\n  rows: 4\n"
                 "  data: [0.0, -1.0, 0.0, 0.5,\n"
                 "         1.0, 0.0, 0.0, 0.0,\n"
                 "         0.0, 0.0, 1.0, 0.0,\n"
                 "         0.0, 0.0, 0.0, 1.0]\n"
                 "rate_hz: 20\n"
                 "resolution: [752, 480]\n"
                 "camera_model: pinhole\n"
                 "intrinsics: [458, 457, 367, 248]\n"
                 "distortion_model: radial-tangential\n"
                 "distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002]\n");
    folder.write("mav0/imu0/sensor.yaml",
                 "sensor_type: imu\nrate_hz: 200\n"
                 "gyroscope_noise_density: 1.7e-04\ngyroscope_random_walk: 2e-05\n"
                 "accelerometer_noise_density: 2e-3\naccelerometer_random_walk: 3e-3\n");
    const pled::LoadedCalibration c = load(folder);
    CHECK(c.rig.num_cameras == 1);
    CHECK(c.rig.imu.rate_hz == 200.0);
    CHECK(c.rig.imu.gyro_density == 1.7e-4);
    CHECK(c.rig.cameras[0].coeffs[1] == 0.07);
    CHECK((c.rig.cameras[0].T_body_cam * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.5, 1, 0))
              .norm() < 1e-12);
    const auto inside = pled::load_calibration(folder.path() / "mav0", {});
    CHECK(std::holds_alternative<pled::LoadedCalibration>(inside));
  }
}

}  // namespace
