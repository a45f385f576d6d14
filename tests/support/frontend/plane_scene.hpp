#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/geometry/pose.hpp"

/// Images whose motion is known exactly: an analytic texture on a plane, seen through a camera.
namespace pled::support {

/// A grey image that owns its pixels.
struct GreyImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
  GreyImage(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w * h)) {}
  [[nodiscard]] ImageView<const std::uint8_t> view() const {
    return {pixels.data(), width, height, width};
  }
  [[nodiscard]] std::uint8_t& at(int y, int x) {
    return pixels[static_cast<std::size_t>(y * width + x)];
  }
};

/// Uniform in [0, 1) with the same value on every library.
[[nodiscard]] inline double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11U) * 0x1p-53;
}

/// Nearly normal, standard deviation 1: the sum of 12 uniform values less 6.
[[nodiscard]] inline double normal(std::mt19937_64& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform(random);
  return sum;
}

/// A smooth texture with edges and corners: waves of all directions pressed through tanh.
class Texture {
 public:
  /// `shortest` and `longest`: wavelengths in the plane's unit.
  Texture(std::uint64_t seed, double shortest, double longest) {
    std::mt19937_64 random(seed);
    for (Wave& w : waves_) {
      const double length = shortest * std::pow(longest / shortest, uniform(random));
      const double angle = 2 * std::numbers::pi * uniform(random);
      w.kx = 2 * std::numbers::pi / length * std::cos(angle);
      w.ky = 2 * std::numbers::pi / length * std::sin(angle);
      w.phase = 2 * std::numbers::pi * uniform(random);
      w.amplitude = std::pow(length / longest, 0.3);
    }
  }
  /// Brightness, 0 ... 1.
  [[nodiscard]] double operator()(double x, double y) const {
    double sum = 0.0;
    for (const Wave& w : waves_) sum += w.amplitude * std::sin(w.kx * x + w.ky * y + w.phase);
    return 0.5 + 0.4 * std::tanh(0.8 * sum);
  }

 private:
  struct Wave {
    double kx = 0, ky = 0, phase = 0, amplitude = 0;
  };
  std::array<Wave, 14> waves_{};
};

/// A camera as a DAVIS 240C, with or without its lens distortion.
[[nodiscard]] inline Camera davis240_camera(bool distorted) {
  CameraCalibration c;
  c.width_px = 240;
  c.height_px = 180;
  c.fx_px = 199.092;
  c.fy_px = 198.829;
  c.cx_px = 132.192;
  c.cy_px = 110.713;
  if (distorted) {
    c.distortion = Distortion::kRadtan;
    c.coeffs = {-0.36844, 0.15095, -0.000296, -0.000759, 0.0};
  }
  return Camera(c);
}

/// The plane z = 0 of the world with a texture; seen from anywhere with z < 0 looking along +z.
class PlaneScene {
 public:
  PlaneScene(const Camera& camera, const Texture& texture) : camera_(camera), texture_(texture) {
    const CameraCalibration& c = camera.calibration();
    for (int y = 0; y < c.height_px; ++y)
      for (int x = 0; x < c.width_px; ++x)
        for (const Eigen::Vector2d& offset : kSamples) {
          const std::optional<Eigen::Vector2d> b = camera.undistort(Eigen::Vector2d(x, y) + offset);
          rays_.push_back(b ? b->homogeneous() : Eigen::Vector3d(0, 0, 1));
        }
  }

  [[nodiscard]] const Camera& camera() const { return camera_; }

  /// Renders what the camera sees: grey = offset + gain x brightness + noise.
  [[nodiscard]] GreyImage render(const Pose& T_world_cam, double gain, double offset,
                                 double noise_grey, std::mt19937_64& random) const {
    const CameraCalibration& c = camera_.calibration();
    GreyImage image(c.width_px, c.height_px);
    const Eigen::Matrix3d R = T_world_cam.R();
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      double sum = 0.0;
      for (std::size_t k = 0; k < kSamples.size(); ++k) {
        const Eigen::Vector3d ray = R * rays_[i * kSamples.size() + k];
        const double s = -T_world_cam.p.z() / ray.z();
        sum += texture_(T_world_cam.p.x() + s * ray.x(), T_world_cam.p.y() + s * ray.y());
      }
      double grey = offset + gain * sum / static_cast<double>(kSamples.size());
      if (noise_grey > 0.0) grey += noise_grey * normal(random);
      image.pixels[i] = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
    }
    return image;
  }

  /// Where the plane's point under `raw_px` of one view is in another.
  [[nodiscard]] std::optional<Eigen::Vector2d> transfer(const Eigen::Vector2d& raw_px,
                                                        const Pose& T_world_from,
                                                        const Pose& T_world_to) const {
    const std::optional<Eigen::Vector2d> b = camera_.undistort(raw_px);
    if (!b) return std::nullopt;
    const Eigen::Vector3d ray = T_world_from.q * b->homogeneous();
    const Eigen::Vector3d point = T_world_from.p - T_world_from.p.z() / ray.z() * ray;
    return camera_.project(T_world_to.inverse() * point);
  }

 private:
  static inline const std::array<Eigen::Vector2d, 4> kSamples{
      Eigen::Vector2d(-0.25, -0.25), Eigen::Vector2d(0.25, -0.25), Eigen::Vector2d(-0.25, 0.25),
      Eigen::Vector2d(0.25, 0.25)};
  Camera camera_;
  Texture texture_;
  std::vector<Eigen::Vector3d> rays_;
};

}  // namespace pled::support
