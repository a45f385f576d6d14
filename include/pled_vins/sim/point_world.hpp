#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/preintegration.hpp"
#include "pled_vins/sim/motion_kind.hpp"

namespace pled::sim {

/// A smooth body motion with exact derivatives: sums of sines.
class SmoothMotion {
 public:
  /// @param mean_speed_mps  mean speed over the first 10 s; ignored when standing or turning.
  SmoothMotion(MotionKind kind, std::uint64_t seed, double mean_speed_mps);

  struct Sample {
    Eigen::Vector3d p_w, v_w, a_w;  ///< m, m/s, m/s^2
    Eigen::Quaterniond q_wb;
    Eigen::Vector3d omega_b;  ///< rad/s, body frame
  };
  [[nodiscard]] Sample at(double t_s) const;

 private:
  struct Wave {
    double amplitude = 0, rate_radps = 0, phase = 0;
  };
  struct Value {
    double x = 0, d1 = 0, d2 = 0;
  };
  using Channel = std::array<Wave, 3>;
  [[nodiscard]] static Value evaluate(const Channel& channel, double t_s);

  MotionKind kind_;
  Eigen::Vector3d steady_mps_ = Eigen::Vector3d::Zero();
  double steady_yaw_radps_ = 0;
  std::array<Channel, 3> position_{};
  std::array<Channel, 3> angle_{};  ///< yaw, pitch, roll
};

struct PointWorldOptions {
  std::uint64_t seed = 1;
  MotionKind motion = MotionKind::kDrone;
  double mean_speed_mps = 1.5;
  double duration_s = 10.0;
  double frame_rate_hz = 20.0;
  int points = 120;           ///< seen at once, <= limits::kMaxPoints
  double pixel_sigma = 0.3;   ///< noise of one axis, pixels
  int max_track_frames = 60;  ///< a track ends after 2 ... this many frames, uniformly drawn
  double min_depth_m = 1.0;
  double max_depth_m = 8.0;
  double moving_share = 0.0;  ///< of points that move on their own
  double moving_speed_mps = 1.0;
  double moving_from_s = 0.0;    ///< after the first frame: until then they stand
  bool moving_together = false;  ///< as one body, along world y; otherwise each its own way
  bool exact_imu = false;        ///< no noise, no walk; the constant biases stay
  ImuNoise imu{.accel_density = 0.002,
               .accel_walk = 0.003,
               .gyro_density = 0.00017,
               .gyro_walk = 2e-5,
               .rate_hz = 200.0};
  Eigen::Vector3d gyro_bias_radps{0.01, -0.02, 0.015};
  Eigen::Vector3d accel_bias_mps2{0.05, -0.04, 0.08};
  double gravity_mps2 = 9.81;
  double still_until_s = 0.0;  ///< stands (exactly) until then, then moves off smoothly
  /// Of a motor, on top of the motion: accelerations of this amplitude at 21 Hz (a quarter of it at
  /// 73 Hz) and turning rates of a tenth of the figure in rad/s. EuRoC's drone on the ground: 1.5.
  double vibration_mps2 = 0.0;
};

/// Points around a moving rig, as an ideal front end would report them, and the
/// rig's IMU. Deterministic by seed. One camera, 240 x 180, f = 199 px, no
/// distortion, looking along body x. Time starts at 1 s.
class PointWorld {
 public:
  explicit PointWorld(const PointWorldOptions& options);

  [[nodiscard]] const PointWorldOptions& options() const { return options_; }
  [[nodiscard]] const RigCalibration& rig() const { return rig_; }
  /// From 0.1 s before the first frame to past the last.
  [[nodiscard]] std::span<const ImuSample> imu() const { return imu_; }
  [[nodiscard]] std::span<const FrameMeasurement> frames() const { return frames_; }
  /// True state, biases included.
  [[nodiscard]] NavState truth(Timestamp t) const;
  /// True position of a point, metres, world.
  [[nodiscard]] Eigen::Vector3d point(FeatureId id, Timestamp t) const;
  [[nodiscard]] bool is_moving(FeatureId id) const { return points_[id].moving; }
  [[nodiscard]] double path_length_m() const;

 private:
  struct Point {
    Eigen::Vector3d p_w;
    Eigen::Vector3d v_w;
    double born_s = 0;
    std::uint32_t frames_left = 0;
    std::uint32_t length = 0;
    bool moving = false;
    std::array<double, 2> last_xy{};
  };

  /// Where it is, metres, world.
  [[nodiscard]] Eigen::Vector3d place(const Point& point, double t_s) const;
  [[nodiscard]] double gaussian();
  [[nodiscard]] double uniform(double lo, double hi);
  [[nodiscard]] SmoothMotion::Sample motion_at(double t_s) const;
  [[nodiscard]] SmoothMotion::Sample shaken(SmoothMotion::Sample s, double t_s) const;
  void make_imu();
  void make_frame(Timestamp t);
  void add_point(double t_s, const Pose& T_wc);
  [[nodiscard]] bool observe(FeatureId id, double t_s, const Pose& T_cw, PointMeasurement& out);

  PointWorldOptions options_;
  std::mt19937_64 random_;
  SmoothMotion motion_;
  RigCalibration rig_;
  std::vector<ImuSample> imu_;
  std::vector<Eigen::Vector3d> gyro_bias_, accel_bias_;
  std::vector<FrameMeasurement> frames_;
  std::vector<Point> points_;
  std::vector<FeatureId> live_;
};

}  // namespace pled::sim
