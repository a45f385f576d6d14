#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/replay/recording.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/turn_history.hpp"
#include "unit/drivers/aedat_reading.hpp"

/// Real events through the library's compensation, judged by contrast: the variance of the image of
/// warped events, which is large when events of one edge meet at one pixel (Gallego et al., CVPR
/// 2018).
namespace pled::support {

/// For a recording that does not state its lens: a pinhole with the principal point in the middle
/// and a focal length usual for the sensor.
inline CameraCalibration nominal(replay::ImageSize size, double focal_px) {
  CameraCalibration c;
  c.width_px = size.width_px;
  c.height_px = size.height_px;
  c.fx_px = c.fy_px = focal_px;
  c.cx_px = 0.5 * (size.width_px - 1);
  c.cy_px = 0.5 * (size.height_px - 1);
  return c;
}

/// Variance after a blur with sigma = 1 px, without which rounding to pixels counts as contrast.
inline double blurred_variance(std::vector<double> image, int width_px, int height_px) {
  constexpr int kReach = 3;
  std::array<double, 2 * kReach + 1> kernel{};
  double sum = 0.0;
  for (int i = -kReach; i <= kReach; ++i)
    sum += kernel[static_cast<std::size_t>(i + kReach)] = std::exp(-0.5 * i * i);
  for (double& k : kernel) k /= sum;
  std::vector<double> out(image.size());
  for (const bool across : {true, false}) {
    for (int y = 0; y < height_px; ++y) {
      for (int x = 0; x < width_px; ++x) {
        double blurred = 0.0;
        for (int i = -kReach; i <= kReach; ++i) {
          const int xx = std::clamp(across ? x + i : x, 0, width_px - 1);
          const int yy = std::clamp(across ? y : y + i, 0, height_px - 1);
          blurred += kernel[static_cast<std::size_t>(i + kReach)] *
                     image[static_cast<std::size_t>(yy * width_px + xx)];
        }
        out[static_cast<std::size_t>(y * width_px + x)] = blurred;
      }
    }
    image.swap(out);
  }
  double mean = 0.0;
  double square = 0.0;
  for (const double v : image) {
    mean += v / static_cast<double>(image.size());
    square += v * v / static_cast<double>(image.size());
  }
  return square - mean * mean;
}

/// A recording of one camera, played once, and its events through the library's compensation.
class EventFootage {
 public:
  /// @param R_body_cam  camera to the axes of the file's inertial samples
  EventFootage(const std::string& path, double focal_px, const Eigen::Quaterniond& R_body_cam)
      : R_body_cam_(R_body_cam) {
    replay::Problems problems;
    const auto recording = replay::Recording::open(path, problems);
    REQUIRE(recording.ok());
    played_ = play(recording.value());
    REQUIRE(played_.events.size() > 1000);
    camera_ = nominal(recording.value().event_size(), focal_px);
    bearings_.resize(UndistortionTable::floats_needed(camera_.width_px, camera_.height_px));
    REQUIRE(table_.build(Camera(camera_), bearings_));
    REQUIRE(warp_.build(table_, rectified(camera_)));
    REQUIRE(!played_.imu.empty());
  }

  [[nodiscard]] const Played& played() const { return played_; }

  /// Whole windows of this length in which the gyro is known.
  [[nodiscard]] std::vector<std::span<const Event>> windows(Duration length) const {
    const std::span<const Event> all = played_.events;
    std::vector<std::span<const Event>> out;
    const auto at = [&](Timestamp t) {
      return std::lower_bound(all.begin(), all.end(), t,
                              [](const Event& e, Timestamp when) { return e.t < when; });
    };
    // A knot of the history lies a little after the first sample.
    const Timestamp first = played_.imu.front().t + Duration{2 * TurnHistory::kKnot_us};
    const Timestamp last = std::min(played_.imu.back().t, played_.events.back().t);
    for (Timestamp t = first; t + length <= last; t = t + length)
      out.emplace_back(at(t), at(t + length));
    return out;
  }

  /// Mean rate of the samples in a window, or in all; axes of the file.
  [[nodiscard]] Eigen::Vector3d mean_rate_radps(std::span<const Event> window = {}) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double n = 0.0;
    for (const ImuSample& sample : played_.imu) {
      if (!window.empty() && (sample.t < window.front().t || sample.t > window.back().t)) continue;
      sum += Eigen::Map<const Eigen::Vector3d>(sample.gyro_radps.data());
      ++n;
    }
    return sum / n;
  }

  [[nodiscard]] double contrast(std::span<const Event> window) const {
    std::vector<WarpedPixel> raw;
    for (const Event& e : window)
      raw.push_back({static_cast<std::int16_t>(e.x_px), static_cast<std::int16_t>(e.y_px)});
    return contrast_at(raw);
  }

  /// Of the events carried to the window's end by the file's gyro.
  [[nodiscard]] double contrast_by_gyro(std::span<const Event> window,
                                        const Eigen::Vector3d& bias_radps) const {
    const auto begin =
        std::find_if(played_.imu.begin(), played_.imu.end(), [&](const ImuSample& s) {
          return s.t + Duration{2 * TurnHistory::kKnot_us} >= window.front().t;
        });
    return contrast_through({begin, played_.imu.end()}, bias_radps, window);
  }

  /// Of the events carried to the window's end by a steady roll about the camera's z.
  [[nodiscard]] double contrast_by_roll(std::span<const Event> window, double roll_radps) const {
    std::vector<ImuSample> made;
    const Eigen::Vector3d rate = R_body_cam_ * Eigen::Vector3d(0.0, 0.0, roll_radps);
    for (Timestamp t = window.front().t - Duration{5000}; t <= window.back().t + Duration{5000};
         t = t + Duration{5000})
      made.push_back({t, {rate.x(), rate.y(), rate.z()}, {}});
    return contrast_through(made, Eigen::Vector3d::Zero(), window);
  }

 private:
  [[nodiscard]] double contrast_through(std::span<const ImuSample> samples,
                                        const Eigen::Vector3d& bias_radps,
                                        std::span<const Event> window) const {
    const auto turn = std::make_unique<TurnHistory>();
    const auto slices = std::make_unique<TurnSlices>();
    const Timestamp t_ref = window.back().t;
    for (const ImuSample& sample : samples) {
      turn->extend({&sample, 1}, bias_radps, R_body_cam_);
      if (sample.t >= t_ref) break;
    }
    REQUIRE(turn->slices(t_ref, window.front().t, t_ref, warp_.slice_error_rad(), *slices));
    std::vector<WarpedPixel> warped(window.size());
    warp_.warp(window, *slices, warped);
    return contrast_at(warped);
  }

  [[nodiscard]] double contrast_at(std::span<const WarpedPixel> pixels) const {
    std::vector<double> image(static_cast<std::size_t>(camera_.width_px * camera_.height_px), 0.0);
    for (const WarpedPixel& p : pixels)
      if (p != kOutsideGrid) image[static_cast<std::size_t>(p.y_px * camera_.width_px + p.x_px)]++;
    return blurred_variance(std::move(image), camera_.width_px, camera_.height_px);
  }

  Played played_;
  CameraCalibration camera_;
  Eigen::Quaterniond R_body_cam_;
  std::vector<float> bearings_;
  UndistortionTable table_;
  EventWarp warp_;
};

}  // namespace pled::support
