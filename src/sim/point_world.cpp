#include "pled_vins/sim/point_world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace pled::sim {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kFirstFrame_s = 1.0017;  // not on an IMU stamp
constexpr double kImuStart_s = 0.9;
constexpr double kPan_radps = 3.0 * std::numbers::pi / 180.0;

double unit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

RigCalibration make_rig(const ImuNoise& noise) {
  RigCalibration rig;
  rig.num_cameras = 1;
  CameraCalibration& c = rig.cameras[0];
  c.width_px = 240;
  c.height_px = 180;
  c.fx_px = c.fy_px = 199.0;
  c.cx_px = 119.5;
  c.cy_px = 89.5;
  Eigen::Matrix3d R_bc;
  R_bc << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  c.T_body_cam = {Eigen::Quaterniond(R_bc), {0.03, -0.01, 0.02}};
  rig.imu = noise;
  return rig;
}

}  // namespace

SmoothMotion::SmoothMotion(MotionKind kind, std::uint64_t seed, double mean_speed_mps)
    : kind_(kind) {
  if (kind == MotionKind::kStill) return;
  if (kind == MotionKind::kCreep) steady_mps_ = mean_speed_mps * Eigen::Vector3d(0.6, 0.8, 0.0);
  if (kind == MotionKind::kPan) steady_yaw_radps_ = kPan_radps;
  if (kind == MotionKind::kCreep || kind == MotionKind::kPan) return;
  std::mt19937_64 random(seed * 7919 + 17);
  const auto wave = [&](double amplitude, double lo_hz, double hi_hz) {
    const double f_hz = lo_hz + (hi_hz - lo_hz) * unit(random);
    return Wave{amplitude * (0.7 + 0.6 * unit(random)), kTwoPi * f_hz, kTwoPi * unit(random)};
  };
  const bool hand = kind == MotionKind::kHandheld;
  const bool car = kind == MotionKind::kCar;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = axis == 2 ? 0.35 : 1.0;
    position_[axis] = {wave(size, 0.08, 0.15), wave(0.25 * size, 0.25, 0.5),
                       wave((hand ? 0.12 : 0.03) * size, 0.8, 1.4)};
    if (car) position_[axis][2].amplitude = 0;
    angle_[axis] = {wave(axis == 0 ? 0.5 : 0.12, 0.08, 0.2), wave(0.08, 0.3, 0.6),
                    wave(hand ? 0.2 : 0.01, 1.0, 1.6)};
  }
  if (car) {
    position_[2] = {};
    angle_ = {};
    angle_[1] = {wave(0.01, 0.5, 1.0), Wave{}, Wave{}};
    angle_[2] = {wave(0.015, 0.5, 1.0), Wave{}, Wave{}};
    steady_mps_.x() = mean_speed_mps;
    for (Wave& w : position_[0]) w.amplitude *= 0.3 * mean_speed_mps;  // |x'| stays > 0
    for (Wave& w : position_[1]) w.amplitude *= 0.5 * mean_speed_mps;
    return;
  }
  double speed = 0;
  for (int k = 0; k < 1000; ++k) speed += at(k * 0.01).v_w.norm() / 1000;
  for (Channel& channel : position_)
    for (Wave& w : channel) w.amplitude *= mean_speed_mps / speed;
}

SmoothMotion::Value SmoothMotion::evaluate(const Channel& channel, double t_s) {
  Value v;
  for (const Wave& w : channel) {
    const double s = std::sin(w.rate_radps * t_s + w.phase);
    const double c = std::cos(w.rate_radps * t_s + w.phase);
    v.x += w.amplitude * s;
    v.d1 += w.amplitude * w.rate_radps * c;
    v.d2 -= w.amplitude * w.rate_radps * w.rate_radps * s;
  }
  return v;
}

SmoothMotion::Sample SmoothMotion::at(double t_s) const {
  std::array<Value, 3> p;
  std::array<Value, 3> a;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = evaluate(position_[i], t_s);
    a[i] = evaluate(angle_[i], t_s);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    p[i].x += steady_mps_[static_cast<int>(i)] * t_s;
    p[i].d1 += steady_mps_[static_cast<int>(i)];
  }
  a[0].x += steady_yaw_radps_ * t_s;
  a[0].d1 += steady_yaw_radps_;
  if (kind_ == MotionKind::kCar) {  // heading follows the path
    const double v2 = p[0].d1 * p[0].d1 + p[1].d1 * p[1].d1;
    a[0] = {std::atan2(p[1].d1, p[0].d1), (p[0].d1 * p[1].d2 - p[1].d1 * p[0].d2) / v2, 0};
  }
  Sample s;
  s.p_w = {p[0].x, p[1].x, p[2].x};
  s.v_w = {p[0].d1, p[1].d1, p[2].d1};
  s.a_w = {p[0].d2, p[1].d2, p[2].d2};
  s.q_wb = Eigen::AngleAxisd(a[0].x, Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(a[1].x, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(a[2].x, Eigen::Vector3d::UnitX());
  // Rates of yaw, pitch, roll (Z-Y-X) to the body's angular rate.
  const double st = std::sin(a[1].x), ct = std::cos(a[1].x);
  const double sf = std::sin(a[2].x), cf = std::cos(a[2].x);
  s.omega_b = {a[2].d1 - a[0].d1 * st, a[1].d1 * cf + a[0].d1 * ct * sf,
               -a[1].d1 * sf + a[0].d1 * ct * cf};
  return s;
}

PointWorld::PointWorld(const PointWorldOptions& options)
    : options_(options),
      random_(options.seed),
      motion_(options.motion, options.seed, options.mean_speed_mps),
      rig_(make_rig(options.imu)) {
  make_imu();
  const int count = static_cast<int>(options_.duration_s * options_.frame_rate_hz);
  frames_.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const Duration since = Duration::from_s(kFirstFrame_s + k / options_.frame_rate_hz);
    make_frame(Timestamp{} + since);
  }
}

double PointWorld::uniform(double lo, double hi) { return lo + (hi - lo) * unit(random_); }

double PointWorld::gaussian() {  // Box-Muller: the same on every library
  const double u = 1.0 - unit(random_);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * unit(random_));
}

SmoothMotion::Sample PointWorld::motion_at(double t_s) const {
  // Motion time m(t): stands until still_until_s, then m'' ramps over one second.
  const double start_s = kFirstFrame_s + options_.still_until_s;
  if (options_.still_until_s <= 0) return shaken(motion_.at(t_s), t_s);
  const double u = std::max(0.0, t_s - start_s);
  double m = u - 0.5, m1 = 1, m2 = 0;
  if (u < 1) {  // m' = smoothstep
    m = u * u * u - 0.5 * u * u * u * u;
    m1 = 3 * u * u - 2 * u * u * u;
    m2 = 6 * u - 6 * u * u;
  }
  SmoothMotion::Sample s = motion_.at(m);
  s.a_w = s.a_w * m1 * m1 + s.v_w * m2;
  s.v_w *= m1;
  s.omega_b *= m1;
  return shaken(s, t_s);
}

SmoothMotion::Sample PointWorld::shaken(SmoothMotion::Sample s, double t_s) const {
  if (options_.vibration_mps2 <= 0) return s;
  struct Tone {
    double rate_radps, share, phase;
  };
  constexpr std::array<Tone, 2> kTones{{{kTwoPi * 21.3, 1.0, 0.4}, {kTwoPi * 73.1, 0.25, 1.9}}};
  const Eigen::Vector3d way = Eigen::Vector3d(0.4, 1.0, 0.3).normalized();
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 0.2, 0.3).normalized();
  double angle_rad = 0, rate_radps = 0;
  for (const Tone& tone : kTones) {
    const double a = tone.share * options_.vibration_mps2;
    const double phase = tone.rate_radps * t_s + tone.phase;
    s.p_w -= way * a * std::sin(phase) / (tone.rate_radps * tone.rate_radps);
    s.v_w -= way * a * std::cos(phase) / tone.rate_radps;
    s.a_w += way * a * std::sin(phase);
    angle_rad += 0.1 * a * std::sin(phase) / tone.rate_radps;
    rate_radps += 0.1 * a * std::cos(phase);
  }
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle_rad, axis));
  s.q_wb = s.q_wb * turn;
  s.omega_b = turn.conjugate() * s.omega_b + rate_radps * axis;
  return s;
}

void PointWorld::make_imu() {
  const double rate = options_.imu.rate_hz;
  const double noise = options_.exact_imu ? 0.0 : 1.0;
  const int count = static_cast<int>((options_.duration_s + 0.3) * rate);
  Eigen::Vector3d bg = options_.gyro_bias_radps;
  Eigen::Vector3d ba = options_.accel_bias_mps2;
  for (int k = 0; k < count; ++k) {
    ImuSample sample;
    sample.t = Timestamp{} + Duration::from_s(kImuStart_s + k / rate);
    const SmoothMotion::Sample m = motion_at(sample.t.seconds());
    const Eigen::Vector3d force_b =
        m.q_wb.conjugate() * (m.a_w + options_.gravity_mps2 * Eigen::Vector3d::UnitZ());
    for (int i = 0; i < 3; ++i) {
      const auto n = static_cast<std::size_t>(i);
      // A density of s per sqrt(Hz) sampled at `rate` has sigma s sqrt(rate).
      sample.gyro_radps[n] =
          m.omega_b[i] + bg[i] + noise * options_.imu.gyro_density * std::sqrt(rate) * gaussian();
      sample.accel_mps2[n] =
          force_b[i] + ba[i] + noise * options_.imu.accel_density * std::sqrt(rate) * gaussian();
    }
    imu_.push_back(sample);
    gyro_bias_.push_back(bg);
    accel_bias_.push_back(ba);
    for (int i = 0; i < 3; ++i) {
      bg[i] += noise * options_.imu.gyro_walk / std::sqrt(rate) * gaussian();
      ba[i] += noise * options_.imu.accel_walk / std::sqrt(rate) * gaussian();
    }
  }
}

NavState PointWorld::truth(Timestamp t) const {
  const SmoothMotion::Sample m = motion_at(t.seconds());
  const double k = (t.seconds() - kImuStart_s) * options_.imu.rate_hz;
  const double last = static_cast<double>(imu_.size() - 1);
  const auto i = static_cast<std::size_t>(std::clamp(k, 0.0, last));
  NavState state;
  state.t = t;
  state.p_wb = m.p_w;
  state.q_wb = m.q_wb;
  state.v_wb = m.v_w;
  state.bg = gyro_bias_[i];
  state.ba = accel_bias_[i];
  return state;
}

Eigen::Vector3d PointWorld::point(FeatureId id, Timestamp t) const {
  const Point& p = points_[id];
  return place(p, t.seconds());
}

Eigen::Vector3d PointWorld::place(const Point& point, double t_s) const {
  const double since_s = std::max(point.born_s, kFirstFrame_s + options_.moving_from_s);
  return point.p_w + point.v_w * std::max(0.0, t_s - since_s);
}

double PointWorld::path_length_m() const {
  double length = 0;
  for (std::size_t k = 1; k < imu_.size(); ++k)
    length += (truth(imu_[k].t).p_wb - truth(imu_[k - 1].t).p_wb).norm();
  return length;
}

void PointWorld::add_point(double t_s, const Pose& T_wc) {
  const CameraCalibration& c = rig_.cameras[0];
  Point point;
  const double u = uniform(4, c.width_px - 5.0);
  const double v = uniform(4, c.height_px - 5.0);
  const double depth_m =
      options_.min_depth_m * std::pow(options_.max_depth_m / options_.min_depth_m, unit(random_));
  const Eigen::Vector3d ray{(u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px, 1.0};
  point.p_w = T_wc * (ray * depth_m);
  point.v_w.setZero();
  point.born_s = t_s;
  point.frames_left =
      2 + static_cast<std::uint32_t>(uniform(0, std::max(1, options_.max_track_frames - 1)));
  point.moving = unit(random_) < options_.moving_share;
  const Eigen::Vector3d direction{gaussian(), gaussian(), gaussian()};
  if (point.moving)
    point.v_w = options_.moving_speed_mps *
                (options_.moving_together ? Eigen::Vector3d::UnitY() : direction.normalized());
  live_.push_back(static_cast<FeatureId>(points_.size()));
  points_.push_back(point);
}

bool PointWorld::observe(FeatureId id, double t_s, const Pose& T_cw, PointMeasurement& out) {
  const CameraCalibration& c = rig_.cameras[0];
  Point& point = points_[id];
  if (point.frames_left == 0) return false;
  const Eigen::Vector3d p_c = T_cw * place(point, t_s);
  if (!(p_c.z() > 0.1)) return false;
  const double u = c.fx_px * p_c.x() / p_c.z() + c.cx_px + options_.pixel_sigma * gaussian();
  const double v = c.fy_px * p_c.y() / p_c.z() + c.cy_px + options_.pixel_sigma * gaussian();
  if (!(u >= 0 && v >= 0 && u <= c.width_px - 1 && v <= c.height_px - 1)) return false;
  --point.frames_left;
  ++point.length;
  out = {};
  out.id = id;
  out.track_length = point.length;
  out.raw_px = {u, v};
  out.bearing_xy = {(u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px};
  if (point.length > 1) {
    for (std::size_t i = 0; i < 2; ++i)
      out.bearing_rate_xyps[i] = (out.bearing_xy[i] - point.last_xy[i]) * options_.frame_rate_hz;
  }
  point.last_xy = out.bearing_xy;
  return true;
}

void PointWorld::make_frame(Timestamp t) {
  FrameMeasurement frame;
  frame.t = t;
  frame.stamp_ns = t.us * 1000;
  const double t_s = t.seconds();
  const Pose T_wc = truth(t).T_world_body() * rig_.cameras[0].T_body_cam;
  const Pose T_cw = T_wc.inverse();
  Eigen::Quaterniond q_now_last = Eigen::Quaterniond::Identity();
  if (!frames_.empty())
    q_now_last = T_cw.q * truth(frames_.back().t).q_wb * rig_.cameras[0].T_body_cam.q;
  std::vector<FeatureId> kept;
  std::vector<double> flow, parallax;
  const auto see = [&](FeatureId id) {
    const std::array<double, 2> last = points_[id].last_xy;
    PointMeasurement seen;
    if (!observe(id, t_s, T_cw, seen) || !frame.points.push_back(seen)) return false;
    if (seen.track_length > 1) {
      const Eigen::Vector2d now{seen.bearing_xy[0], seen.bearing_xy[1]};
      const Eigen::Vector3d turned = q_now_last * Eigen::Vector3d(last[0], last[1], 1.0);
      flow.push_back((now - Eigen::Vector2d(last[0], last[1])).norm());
      parallax.push_back((now - turned.head<2>() / turned.z()).norm());
    }
    kept.push_back(id);
    return true;
  };
  for (const FeatureId id : live_)
    if (!see(id)) ++frame.lost;
  live_.clear();
  while (static_cast<int>(kept.size()) < options_.points) {
    add_point(t_s, T_wc);
    if (!see(live_.back()) && frame.points.full()) break;
  }
  live_ = kept;
  const auto median_px = [&](std::vector<double>& values) {
    if (values.empty()) return 0.0;
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2] * rig_.cameras[0].fx_px;
  };
  frame.median_flow_px = median_px(flow);
  frame.median_parallax_px = median_px(parallax);
  frames_.push_back(frame);
}

}  // namespace pled::sim
