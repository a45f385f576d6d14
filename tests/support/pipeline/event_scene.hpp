#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/geometry/pose.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled::support {

/// A body that swings to and fro: turns about one axis and goes along one line, both as sines that
/// start at rest.
struct SwingingBody {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d go_m = Eigen::Vector3d::Zero();
  double rate_hz = 0.5;

  [[nodiscard]] Pose pose(double t_s) const {
    const double swing = 0.5 * (1.0 - std::cos(kTurn * rate_hz * t_s));
    return {so3::exp(turn_rad * swing), Eigen::Vector3d(0, 0, -1) + go_m * swing};
  }
  [[nodiscard]] Eigen::Vector3d gyro_radps(double t_s) const {
    return 0.5 * kTurn * rate_hz * std::sin(kTurn * rate_hz * t_s) * turn_rad;
  }

 private:
  static constexpr double kTurn = 6.283185307179586;
};

/// The plane z = 0 of the world, laid out with squares of random grey, and the events that a camera
/// sees that moves before it, looking along +z. A pixel fires each time the logarithm of its
/// brightness has changed by a contrast threshold.
class EventScene {
 public:
  static constexpr double kThreshold = 0.25;

  EventScene(const CameraCalibration& camera, double square_m, std::uint64_t seed)
      : camera_(camera), T_body_cam_(camera.T_body_cam), square_m_(square_m) {
    std::mt19937_64 random(seed);
    for (float& value : log_grey_) value = 1.6F * static_cast<float>(random() >> 40U) * 0x1p-24F;
    for (int y = 0; y < camera.height_px; ++y)
      for (int x = 0; x < camera.width_px; ++x) {
        const std::optional<Eigen::Vector2d> b = camera_.undistort(Eigen::Vector2d(x, y));
        rays_.push_back(b ? b->homogeneous() : Eigen::Vector3d(0, 0, 1));
      }
  }

  /// Events of [from, to] in time order; stamps on the clock of `body`'s time.
  /// @param body  anything with `Pose pose(double t_s) const`
  template <typename Body>
  [[nodiscard]] std::vector<Event> events(const Body& body, std::int64_t from_us,
                                          std::int64_t to_us, std::int64_t step_us = 2000) const {
    std::vector<Event> out;
    std::vector<float> before = brightness(body.pose(static_cast<double>(from_us) * 1e-6));
    std::vector<float> level = before;  // at each pixel's last event
    for (std::int64_t t = from_us; t < to_us; t += step_us) {
      const std::vector<float> now = brightness(body.pose(static_cast<double>(t + step_us) * 1e-6));
      const std::size_t first = out.size();
      for (std::size_t i = 0; i < now.size(); ++i)
        fire(i, {t, step_us, before[i], now[i]}, level[i], out);
      std::stable_sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
                       [](const Event& a, const Event& b) { return a.t < b.t; });
      before = now;
    }
    return out;
  }

  /// Where the plane's point under a raw pixel is when the body has moved.
  [[nodiscard]] std::optional<Eigen::Vector2d> transfer(const Eigen::Vector2d& raw_px,
                                                        const Pose& T_world_from,
                                                        const Pose& T_world_to) const {
    const std::optional<Eigen::Vector2d> b = camera_.undistort(raw_px);
    if (!b) return std::nullopt;
    const Pose from = T_world_from * T_body_cam_;
    const Eigen::Vector3d ray = from.q * b->homogeneous();
    const Eigen::Vector3d point = from.p - from.p.z() / ray.z() * ray;
    return camera_.project((T_world_to * T_body_cam_).inverse() * point);
  }

 private:
  static constexpr int kSquares = 256;
  static constexpr double kSoftness = 0.08;  ///< of a square's side: the width of its border

  struct Step {
    std::int64_t begin_us, length_us;
    float from, to;
  };

  void fire(std::size_t pixel, const Step& step, float& level, std::vector<Event>& out) const {
    const auto width = static_cast<std::size_t>(camera_.calibration().width_px);
    constexpr auto kStep = static_cast<float>(kThreshold);
    while (std::abs(step.to - level) >= kStep) {
      const float sign = step.to > level ? 1.0F : -1.0F;
      level += sign * kStep;
      const float share = std::clamp((level - step.from) / (step.to - step.from), 0.0F, 1.0F);
      const auto dt_us = static_cast<std::int64_t>(share * static_cast<float>(step.length_us - 1));
      out.push_back({{step.begin_us + dt_us},
                     static_cast<std::uint16_t>(pixel % width),
                     static_cast<std::uint16_t>(pixel / width),
                     sign > 0.0F ? Polarity::kOn : Polarity::kOff});
    }
  }

  /// Logarithm of the plane's brightness, with borders that are soft in one direction each.
  [[nodiscard]] float plane(double x_m, double y_m) const {
    const double x = x_m / square_m_ + 0.5 * kSquares;
    const double y = y_m / square_m_ + 0.5 * kSquares;
    const double x0 = std::floor(x), y0 = std::floor(y);
    const auto blend = [](double inside) {
      return static_cast<float>(std::clamp((inside - 1.0) / kSoftness + 1.0, 0.0, 1.0));
    };
    const float bx = blend(x - x0), by = blend(y - y0);
    const auto at = [&](double dx, double dy) {
      const auto i = static_cast<std::uint32_t>(static_cast<std::int64_t>(x0 + dx)) % kSquares;
      const auto k = static_cast<std::uint32_t>(static_cast<std::int64_t>(y0 + dy)) % kSquares;
      return log_grey_[k * kSquares + i];
    };
    return (1 - by) * ((1 - bx) * at(0, 0) + bx * at(1, 0)) +
           by * ((1 - bx) * at(0, 1) + bx * at(1, 1));
  }

  [[nodiscard]] std::vector<float> brightness(const Pose& T_world_body) const {
    const Pose T = T_world_body * T_body_cam_;
    const Eigen::Matrix3d R = T.R();
    std::vector<float> out(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const Eigen::Vector3d ray = R * rays_[i];
      const double s = -T.p.z() / ray.z();
      out[i] = plane(T.p.x() + s * ray.x(), T.p.y() + s * ray.y());
    }
    return out;
  }

  Camera camera_;
  Pose T_body_cam_;
  double square_m_;
  std::array<float, kSquares * kSquares> log_grey_{};
  std::vector<Eigen::Vector3d> rays_;
};

}  // namespace pled::support
