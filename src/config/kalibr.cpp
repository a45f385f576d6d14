#include <algorithm>
#include <sstream>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "pled_vins/config/calibration.hpp"
#include "src/config/yaml_reader.hpp"

namespace pled {
namespace {

namespace fs = std::filesystem;

constexpr double kRotationTolerance = 1e-3;
constexpr double kLastRowTolerance = 1e-9;

// Wide enough for every device, too narrow for another unit or a slipped digit.
constexpr yaml::Range kTimeShift_s{-1.0, 1.0, "s"};
constexpr yaml::Range kSide_px{1, 4096, "px"};
constexpr yaml::Range kFocal_px{1.0, 1e5, "px"};
constexpr yaml::Range kCoefficient{-1000.0, 1000.0, {}};  // the high orders of long lenses
constexpr yaml::Range kLever_m{-100.0, 100.0, "m"};
constexpr yaml::Range kNoise{1e-9, 100.0, {}};  // densities and walks, in their SI units
constexpr yaml::Range kImuRate_hz{1.0, 1e5, "Hz"};

/// Checks a 4 x 4 transform and makes its rotation exactly orthonormal: calibration
/// files carry a few digits only.
Pose to_pose(const Eigen::Matrix4d& T, const yaml::Document& document, const YAML::Node& node,
             const std::string& key) {
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kLastRowTolerance)
    document.fail(node, key, "is no rigid transform: its last row must be 0 0 0 1");
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const Eigen::Matrix3d off = R.transpose() * R - Eigen::Matrix3d::Identity();
  if (!(off.cwiseAbs().maxCoeff() <= kRotationTolerance))
    document.fail(node, key, "is no rigid transform: its 3 x 3 part is not orthonormal to 0.001");
  if (!(R.determinant() > 0))
    document.fail(node, key, "is no rigid transform: its 3 x 3 part mirrors (determinant -1)");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest_rotation = svd.matrixU() * svd.matrixV().transpose();
  for (const double lever_m : T.topRightCorner<3, 1>())
    document.check_range(node, lever_m, key + " (translation)", kLever_m);
  Pose pose;
  pose.q = Eigen::Quaterniond(nearest_rotation).normalized();
  pose.p = T.topRightCorner<3, 1>();
  return pose;
}

/// Four rows of four (Kalibr), sixteen numbers, or OpenCV's rows/cols/data.
Pose read_transform(const yaml::Document& document, const YAML::Node& node,
                    const std::string& key) {
  std::vector<double> values;
  if (node.IsMap()) {
    values = document.numbers(document.required(node, "data", key + ".data"), key);
  } else if (node.IsSequence() && node.size() > 0 && node[0].IsSequence()) {
    if (node.size() != 4)
      document.fail(node, key,
                    "has " + std::to_string(node.size()) +
                        " rows: must be 4 rows of 4 numbers, the last [0, 0, 0, 1]");
    for (const YAML::Node& row : node) {
      const std::vector<double> four = document.numbers(row, key);
      if (four.size() != 4) document.fail(row, key, "must have 4 numbers in each row");
      values.insert(values.end(), four.begin(), four.end());
    }
  } else {
    values = document.numbers(node, key);
  }
  if (values.size() != 16) document.fail(node, key, "must be 4 rows of 4 numbers");
  const Eigen::Matrix4d T =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  return to_pose(T, document, node, key);
}

/// `coeffs_name`: distortion_coeffs in Kalibr's files, distortion_coefficients in EuRoC's.
void read_lens(const yaml::Document& document, const YAML::Node& map, const char* coeffs_name,
               const std::string& prefix, CameraCalibration& camera) {
  const std::string model_key = prefix + "distortion_model";
  const YAML::Node model = document.required(map, "distortion_model", model_key);
  const std::string name = document.text(model, model_key);
  if (name == "none") {
    camera.distortion = Distortion::kNone;
    return;
  }
  if (name == "radtan" || name == "radial-tangential" || name == "plumb_bob") {
    camera.distortion = Distortion::kRadtan;
  } else if (name == "equidistant" || name == "equi") {
    camera.distortion = Distortion::kEquidistant;
  } else {
    document.fail(model, model_key, "'" + name + "' is not supported: radtan, equidistant or none");
  }
  const std::string key = prefix + coeffs_name;
  const YAML::Node coeffs = document.required(map, coeffs_name, key);
  const std::vector<double> values = document.numbers(coeffs, key);
  const bool five = values.size() == 5 && camera.distortion == Distortion::kRadtan;
  if (values.size() != 4 && !five) document.fail(coeffs, key, "must be 4 numbers (radtan also 5)");
  for (const double value : values) document.check_range(coeffs, value, key, kCoefficient);
  std::copy(values.begin(), values.end(), camera.coeffs.begin());
}

void read_resolution(const yaml::Document& document, const YAML::Node& node, const std::string& key,
                     CameraCalibration& camera) {
  if (!node.IsSequence() || node.size() != 2)
    document.fail(node, key, "must be [width, height] in pixels");
  camera.width_px = document.whole_number(node[0], key);
  camera.height_px = document.whole_number(node[1], key);
  document.check_range(node[0], camera.width_px, key, kSide_px);
  document.check_range(node[1], camera.height_px, key, kSide_px);
}

void read_intrinsics(const yaml::Document& document, const YAML::Node& node, const std::string& key,
                     CameraCalibration& camera) {
  const std::vector<double> values = document.numbers(node, key);
  if (values.size() != 4) document.fail(node, key, "must be [fx, fy, cx, cy]");
  camera.fx_px = values[0];
  camera.fy_px = values[1];
  camera.cx_px = values[2];
  camera.cy_px = values[3];
}

/// What no pinhole camera can have.
void check_intrinsics(const yaml::Document& document, const YAML::Node& node,
                      const std::string& key, const CameraCalibration& camera) {
  if (!(camera.fx_px > 0 && camera.fy_px > 0))
    document.fail(node, key, "the focal lengths must be positive");
  for (const double focal_px : {camera.fx_px, camera.fy_px})
    document.check_range(node, focal_px, key + " (focal length)", kFocal_px);
  if (!(camera.cx_px > 0 && camera.cx_px < camera.width_px && camera.cy_px > 0 &&
        camera.cy_px < camera.height_px))
    document.fail(node, key,
                  "the principal point lies outside the image of " +
                      std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) +
                      " pixels");
}

/// calib.txt of the RPG layout: fx fy cx cy k1 k2 p1 p2 k3.
void read_calib_txt(const fs::path& file, CameraCalibration& camera) {
  std::istringstream words(yaml::read_text_file(file));
  std::vector<double> values;
  for (std::string word; words >> word;) {
    double value = 0.0;
    if (!yaml::parse(word, value))
      throw yaml::Failure{{file.string(), 1, {}, "'" + word + "' is not a number"}};
    values.push_back(value);
  }
  if (values.size() != 9 && values.size() != 8)
    throw yaml::Failure{
        {file.string(),
         1,
         {},
         "must be fx fy cx cy k1 k2 p1 p2 k3, not " + std::to_string(values.size()) + " numbers"}};
  camera.fx_px = values[0];
  camera.fy_px = values[1];
  camera.cx_px = values[2];
  camera.cy_px = values[3];
  camera.distortion = Distortion::kRadtan;
  std::copy(values.begin() + 4, values.end(), camera.coeffs.begin());
}

/// Reads the cameras of a camchain.yaml one after the other.
class CamchainReader {
 public:
  CamchainReader(const yaml::Document& document, fs::path calib_txt)
      : document_(document), calib_txt_(std::move(calib_txt)) {}

  std::vector<NamedCamera> read() {
    const YAML::Node& root = document_.root();
    if (!root.IsMap()) document_.fail(root, {}, "holds no cameras (cam0:, cam1:)");
    for (const auto& entry : root) {
      const std::string name = document_.text(entry.first, "?");
      const bool is_camera = name.starts_with("cam") && entry.second.IsMap();
      if (!is_camera) continue;  // Kalibr writes other things beside its cameras
      for (const NamedCamera& earlier : cameras_)
        if (earlier.name == name) document_.fail(entry.first, name, "stands here a second time");
      if (cameras_.size() == limits::kMaxCameras)
        document_.fail(entry.first, name, "is one camera too many: two at most");
      cameras_.push_back({name, read_camera(name, entry.second)});
    }
    if (cameras_.empty()) document_.fail("cam0", "is missing: the file holds no camera");
    return cameras_;
  }

 private:
  CameraCalibration read_camera(const std::string& name, const YAML::Node& node) {
    const std::string prefix = name + ".";
    document_.refuse_repeats(node, prefix);
    const auto required = [&](const char* key) {
      return document_.required(node, key, prefix + key);
    };
    CameraCalibration camera;
    const YAML::Node model = required("camera_model");
    if (document_.text(model, prefix + "camera_model") != "pinhole")
      document_.fail(model, prefix + "camera_model",
                     "'" + model.Scalar() + "' is not supported: pinhole only");
    read_resolution(document_, required("resolution"), prefix + "resolution", camera);
    if (!node["intrinsics"] && !calib_txt_.empty()) {
      read_calib_txt(calib_txt_, camera);
      check_intrinsics(document_, node, "intrinsics of " + calib_txt_.string(), camera);
    } else {
      const YAML::Node intrinsics = required("intrinsics");
      read_intrinsics(document_, intrinsics, prefix + "intrinsics", camera);
      check_intrinsics(document_, intrinsics, prefix + "intrinsics", camera);
      read_lens(document_, node, "distortion_coeffs", prefix, camera);
    }
    camera.T_body_cam = read_T_cam_imu(node, prefix).inverse();
    if (const YAML::Node shift = node["timeshift_cam_imu"])
      camera.time_shift_s = document_.number_in(shift, prefix + "timeshift_cam_imu", kTimeShift_s);
    return camera;
  }

  /// Given, or chained from the camera before: T_cn_imu = T_cn_cnm1 T_cnm1_imu.
  Pose read_T_cam_imu(const YAML::Node& node, const std::string& prefix) {
    if (const YAML::Node given = node["T_cam_imu"])
      return read_transform(document_, given, prefix + "T_cam_imu");
    const YAML::Node chained = node["T_cn_cnm1"];
    if (!chained || cameras_.empty())
      document_.fail(node, prefix + "T_cam_imu",
                     "is missing: where the camera sits on the IMU (Kalibr's camera-IMU "
                     "calibration gives it)");
    const Pose T_cn_cnm1 = read_transform(document_, chained, prefix + "T_cn_cnm1");
    return T_cn_cnm1 * cameras_.back().camera.T_body_cam.inverse();
  }

  const yaml::Document& document_;
  fs::path calib_txt_;
  std::vector<NamedCamera> cameras_;
};

double required_in(const yaml::Document& document, const YAML::Node& map, const std::string& key,
                   const yaml::Range& range) {
  return document.number_in(document.required(map, key, key), key, range);
}

/// The body frame is the IMU's own; another one would turn every reading.
void refuse_other_body(const yaml::Document& document, const YAML::Node& map,
                       const std::string& key) {
  const YAML::Node node = map[key];
  if (!node) return;
  const Pose T = read_transform(document, node, key);
  if (T.p.norm() > 1e-9 || T.q.vec().norm() > 1e-9)
    document.fail(node, key, "must be the identity: the body frame is the IMU's");
}

ImuNoise read_imu_noise(const yaml::Document& document) {
  const YAML::Node& root = document.root();
  if (!root.IsMap()) document.fail(root, {}, "holds no `key: value` lines");
  const YAML::Node map = root["imu0"] ? document.required(root, "imu0", "imu0") : root;
  if (!map.IsMap()) document.fail(map, "imu0", "holds no `key: value` lines");
  document.refuse_repeats(map, {});
  refuse_other_body(document, map, "T_i_b");
  refuse_other_body(document, map, "T_BS");
  ImuNoise noise;
  noise.accel_density = required_in(document, map, "accelerometer_noise_density", kNoise);
  noise.accel_walk = required_in(document, map, "accelerometer_random_walk", kNoise);
  noise.gyro_density = required_in(document, map, "gyroscope_noise_density", kNoise);
  noise.gyro_walk = required_in(document, map, "gyroscope_random_walk", kNoise);
  const bool euroc = !map["update_rate"] && map["rate_hz"];
  noise.rate_hz = required_in(document, map, euroc ? "rate_hz" : "update_rate", kImuRate_hz);
  return noise;
}

/// Runs `read` and turns what it throws into an error.
template <typename T, typename Read>
std::variant<T, ConfigError> caught(const fs::path& file, Read read) {
  try {
    return read();
  } catch (const yaml::Failure& failure) {
    return failure.error;
  } catch (const std::exception& error) {  // from yaml-cpp or the file system
    return ConfigError{file.string(), 0, {}, error.what()};
  }
}

}  // namespace

std::variant<std::vector<NamedCamera>, ConfigError> load_camchain(const fs::path& file,
                                                                  const fs::path& calib_txt) {
  return caught<std::vector<NamedCamera>>(file, [&] {
    const yaml::Document document = yaml::Document::from_file(file);
    return CamchainReader(document, calib_txt).read();
  });
}

std::variant<ImuNoise, ConfigError> load_imu_noise(const fs::path& file) {
  return caught<ImuNoise>(file, [&] { return read_imu_noise(yaml::Document::from_file(file)); });
}

std::variant<CameraCalibration, ConfigError> load_euroc_camera(const fs::path& file) {
  return caught<CameraCalibration>(file, [&] {
    const yaml::Document document = yaml::Document::from_file(file);
    const YAML::Node& root = document.root();
    document.refuse_repeats(root, {});
    const auto required = [&](const char* key) { return document.required(root, key, key); };
    CameraCalibration camera;
    read_resolution(document, required("resolution"), "resolution", camera);
    const YAML::Node intrinsics = required("intrinsics");
    read_intrinsics(document, intrinsics, "intrinsics", camera);
    check_intrinsics(document, intrinsics, "intrinsics", camera);
    read_lens(document, root, "distortion_coefficients", "", camera);
    camera.T_body_cam = read_transform(document, required("T_BS"), "T_BS");
    return camera;
  });
}

}  // namespace pled
