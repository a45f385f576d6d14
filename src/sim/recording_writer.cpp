#include "src/sim/recording_writer.hpp"

#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include "src/sim/png_file.hpp"

namespace pled::sim {
namespace {

namespace fs = std::filesystem;

/// printf into a string; lines are short.
template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char line[512];
  const int n = std::snprintf(line, sizeof line, pattern, values...);
  return n > 0 ? std::string(line, static_cast<std::size_t>(n)) : std::string();
}

Result<void> write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) return ErrorCode::kIoFailure;
  return {};
}

std::string picture_name(const char* kind, std::uint64_t index) {
  return format("%ss/%s_%08llu.png", kind == std::string("frame") ? "image" : kind, kind,
                static_cast<unsigned long long>(index));
}

/// A folder for pictures without those of an earlier recording: they would look like part of this
/// one.
Result<void> make_picture_folder(const fs::path& path, const std::string& kind) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return Error{ErrorCode::kIoFailure, error.value()};
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    if (entry.path().filename().string().starts_with(kind + "_")) fs::remove(entry.path(), error);
  }
  if (error) return Error{ErrorCode::kIoFailure, error.value()};
  return {};
}

/// Removes what an earlier recording left and this one will not write: it would look like a part of
/// it.
Result<void> remove_leftovers(const fs::path& dir, const SimulationOptions& options) {
  std::error_code error;
  const auto remove = [&](const char* name) {
    if (!error) fs::remove(dir / name, error);
  };
  remove(options.text_events ? "events.raw" : "events.txt");
  if (!options.event_camera) remove("settings.yaml");
  if (!options.with_depth) {
    remove("depth.txt");
    if (!error && fs::exists(dir / "depths", error)) {
      PLED_TRY(make_picture_folder(dir / "depths", "depth"));
      std::error_code holds_more;
      fs::remove(dir / "depths", holds_more);
    }
  }
  if (error) return Error{ErrorCode::kIoFailure, error.value()};
  return {};
}

/// A camera as camchain.yaml has it.
std::string camera_entry(const char* name, const CameraCalibration& c) {
  const auto& k = c.coeffs;
  std::string text = std::string(name) + ":\n  camera_model: pinhole\n";
  text += format("  intrinsics: [%.9g, %.9g, %.9g, %.9g]\n", c.fx_px, c.fy_px, c.cx_px, c.cy_px);
  text += c.distortion == Distortion::kEquidistant ? "  distortion_model: equidistant\n"
                                                   : "  distortion_model: radtan\n";
  text += format("  distortion_coeffs: [%.9g, %.9g, %.9g, %.9g]\n  T_cam_imu:\n", k[0], k[1], k[2],
                 k[3]);
  const Pose T_cam_imu = c.T_body_cam.inverse();
  const Eigen::Matrix3d R = T_cam_imu.R();
  for (int row = 0; row < 3; ++row) {
    text += format("  - [%.12g, %.12g, %.12g, %.12g]\n", R(row, 0), R(row, 1), R(row, 2),
                   T_cam_imu.p(row));
  }
  text += "  - [0, 0, 0, 1]\n";
  text += format("  timeshift_cam_imu: %.9g\n", c.time_shift_s);
  return text + format("  resolution: [%d, %d]\n", c.width_px, c.height_px);
}

}  // namespace

Result<void> RecordingWriter::create(const SimulationOptions& options) {
  PLED_TRY(make_picture_folder(dir_ / "images", "frame"));
  PLED_TRY(make_picture_folder(dir_ / "masks", "mask"));
  with_depth_ = options.with_depth;
  if (with_depth_) PLED_TRY(make_picture_folder(dir_ / "depths", "depth"));
  PLED_TRY(remove_leftovers(dir_, options));
  const CameraCalibration& camera = options.camera_of_events();
  text_events_ = options.text_events;
  encoder_ = Evt3Encoder{camera.width_px};
  events_.open(dir_ / (text_events_ ? "events.txt" : "events.raw"),
               std::ios::binary | std::ios::trunc);
  if (!text_events_) events_ << Evt3Encoder::raw_header(camera.width_px, camera.height_px);
  if (!events_) return ErrorCode::kIoFailure;
  return {};
}

Result<void> RecordingWriter::write_calibration(const SimulationOptions& options) {
  const CameraCalibration& c = options.camera;
  const auto& k = c.coeffs;
  const ImuNoise& imu = options.imu.noise;
  std::string chain = camera_entry("cam0", c);
  if (options.event_camera) {
    chain += camera_entry("cam1", *options.event_camera);
    PLED_TRY(write_text(dir_ / "settings.yaml",
                        "sensors:\n  frame_camera: cam0\n  event_camera: cam1\n"));
  }
  PLED_TRY(write_text(dir_ / "camchain.yaml", chain));

  PLED_TRY(write_text(dir_ / "calib.txt",
                      format("%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", c.fx_px, c.fy_px,
                             c.cx_px, c.cy_px, k[0], k[1], k[2], k[3], k[4])));
  std::string noise;
  noise += format("accelerometer_noise_density: %.8f   # m/s^2/sqrt(Hz)\n", imu.accel_density);
  noise += format("accelerometer_random_walk: %.8f   # m/s^3/sqrt(Hz)\n", imu.accel_walk);
  noise += format("gyroscope_noise_density: %.8f   # rad/s/sqrt(Hz)\n", imu.gyro_density);
  noise += format("gyroscope_random_walk: %.8f   # rad/s^2/sqrt(Hz)\n", imu.gyro_walk);
  noise += format("rostopic: /imu0\nupdate_rate: %.9g\n", imu.rate_hz);
  return write_text(dir_ / "imu.yaml", noise);
}

Result<void> RecordingWriter::write_imu(std::span<const ImuSample> samples) {
  std::string text;
  for (const ImuSample& s : samples) {
    text +=
        format("%.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", s.t.seconds(), s.accel_mps2[0],
               s.accel_mps2[1], s.accel_mps2[2], s.gyro_radps[0], s.gyro_radps[1], s.gyro_radps[2]);
  }
  return write_text(dir_ / "imu.txt", text);
}

Result<void> RecordingWriter::write_truth(const Trajectory& trajectory, double duration_s,
                                          double rate_hz) {
  std::string text;
  const auto count = static_cast<std::uint64_t>(duration_s * rate_hz + 1e-6) + 1;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double t_s = static_cast<double>(i) / rate_hz;
    const Pose T = trajectory.at(t_s).T_world_body;
    text += format("%.9f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", t_s, T.p.x(), T.p.y(), T.p.z(),
                   T.q.x(), T.q.y(), T.q.z(), T.q.w());
  }
  return write_text(dir_ / "groundtruth.txt", text);
}

Result<void> RecordingWriter::write_states(const Trajectory& trajectory, const SimulatedImu& imu) {
  std::string text =
      "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z [],v_x [m s^-1],"
      "v_y [m s^-1],v_z [m s^-1],b_w_x [rad s^-1],b_w_y [rad s^-1],b_w_z [rad s^-1],"
      "b_a_x [m s^-2],b_a_y [m s^-2],b_a_z [m s^-2]\n";
  for (std::size_t i = 0; i < imu.samples.size(); ++i) {
    const Timestamp t = imu.samples[i].t;
    const Kinematics k = trajectory.at(t.seconds());
    const Eigen::Vector3d& p = k.T_world_body.p;
    const Eigen::Quaterniond& q = k.T_world_body.q;
    const Eigen::Vector3d &v = k.v_wb_mps, &bg = imu.gyro_bias_radps[i],
                          &ba = imu.accel_bias_mps2[i];
    text += format("%lld,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f",
                   static_cast<long long>(t.us) * 1000, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(),
                   q.z(), v.x(), v.y(), v.z());
    text +=
        format(",%.9f,%.9f,%.9f,%.9f,%.9f,%.9f\n", bg.x(), bg.y(), bg.z(), ba.x(), ba.y(), ba.z());
  }
  return write_text(dir_ / "states.csv", text);
}

Result<void> RecordingWriter::write_frame(std::uint64_t index, const Frame& frame, int width_px,
                                          int height_px) {
  if (with_depth_)
    PLED_TRY(write_png16(dir_ / picture_name("depth", index), frame.depth_mm, width_px, height_px));
  PLED_TRY(write_png(dir_ / picture_name("frame", index),
                     {frame.grey.data(), width_px, height_px, width_px}));
  return write_png(dir_ / picture_name("mask", index),
                   {frame.mask.data(), width_px, height_px, width_px});
}

Result<void> RecordingWriter::write_frame_lists(std::span<const ListedFrame> frames) {
  std::string images, masks, depths;
  for (const ListedFrame& frame : frames) {
    const std::string stamp = format("%.9f ", frame.stamp_s);
    images += stamp + picture_name("frame", frame.index) + "\n";
    masks += stamp + picture_name("mask", frame.index) + "\n";
    depths += stamp + picture_name("depth", frame.index) + "\n";
  }
  PLED_TRY(write_text(dir_ / "images.txt", images));
  if (with_depth_) PLED_TRY(write_text(dir_ / "depth.txt", depths));
  return write_text(dir_ / "masks.txt", masks);
}

Result<void> RecordingWriter::write_events(std::span<const Event> events) {
  if (text_events_) {
    for (const Event& e : events)
      events_ << format("%.6f %d %d %d\n", e.t.seconds(), int{e.x_px}, int{e.y_px},
                        e.polarity == Polarity::kOn ? 1 : 0);
    if (!events_) return ErrorCode::kIoFailure;
    return {};
  }
  bytes_.clear();
  encoder_.encode(events, bytes_);
  events_.write(reinterpret_cast<const char*>(bytes_.data()),
                static_cast<std::streamsize>(bytes_.size()));
  if (!events_) return ErrorCode::kIoFailure;
  return {};
}

Result<void> RecordingWriter::finish() {
  events_.close();
  if (!events_) return ErrorCode::kIoFailure;
  return {};
}

}  // namespace pled::sim
