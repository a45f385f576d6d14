#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <Eigen/Core>
#include <doctest/doctest.h>

#include "pled_vins/frontend/lines/line_detector.hpp"
#include "support/frontend/plane_scene.hpp"

/// Pictures whose straight edges are known.
namespace pled::support {

/// A pinhole camera without distortion.
[[nodiscard]] inline Camera plain_camera(int width_px, int height_px) {
  CameraCalibration c;
  c.width_px = width_px;
  c.height_px = height_px;
  c.fx_px = c.fy_px = 200.0;
  c.cx_px = 0.5 * (width_px - 1);
  c.cy_px = 0.5 * (height_px - 1);
  return Camera(c);
}

/// Each pixel is the mean of grey(x, y) over 4 x 4 places in it.
template <typename Grey>
[[nodiscard]] GreyImage draw(int width, int height, const Grey& grey) {
  GreyImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int i = 0; i < 16; ++i) sum += grey(x + (i % 4 - 1.5) / 4.0, y + (i / 4 - 1.5) / 4.0);
      image.at(y, x) = static_cast<std::uint8_t>(std::clamp(std::lround(sum / 16.0), 0L, 255L));
    }
  return image;
}

/// A rectangle turned about its middle.
class Rectangle {
 public:
  Rectangle(const Eigen::Vector2d& middle, double half_width, double half_height, double turn_rad)
      : middle_(middle),
        half_width_(half_width),
        half_height_(half_height),
        axis_(std::cos(turn_rad), std::sin(turn_rad)) {}

  [[nodiscard]] const Eigen::Vector2d& middle() const { return middle_; }
  /// Coordinates in the rectangle's own axes.
  [[nodiscard]] Eigen::Vector2d inner(double x, double y) const {
    const double u = x - middle_.x();
    const double v = y - middle_.y();
    return {axis_.x() * u + axis_.y() * v, axis_.x() * v - axis_.y() * u};
  }
  [[nodiscard]] bool holds(double x, double y) const {
    const Eigen::Vector2d at = inner(x, y);
    return std::abs(at.x()) <= half_width_ && std::abs(at.y()) <= half_height_;
  }
  /// Clockwise on a screen, from the one at the upper left before the turn.
  [[nodiscard]] Eigen::Vector2d corner(std::size_t k) const {
    const double u = k == 0 || k == 3 ? -half_width_ : half_width_;
    const double v = k < 2 ? -half_height_ : half_height_;
    return middle_ + u * axis_ + v * Eigen::Vector2d(-axis_.y(), axis_.x());
  }

 private:
  Eigen::Vector2d middle_;
  double half_width_;
  double half_height_;
  Eigen::Vector2d axis_;
};

/// A detector with its memory.
class OwnedDetector {
 public:
  explicit OwnedDetector(const Camera& camera, LinePicture kind = LinePicture::kGrey,
                         const LineConfig& config = {})
      : storage_(std::make_unique<Storage>()),
        detector_(std::make_unique<LineDetector>(config, camera, kind, storage_->view())) {}

  [[nodiscard]] DetectedLines detect(const GreyImage& image) {
    DetectedLines lines;
    REQUIRE(detector_->detect(image.view(), lines));
    return lines;
  }
  [[nodiscard]] LineDetector& detector() { return *detector_; }

 private:
  using Storage = LineStorage<1280, 720>;
  std::unique_ptr<Storage> storage_;
  std::unique_ptr<LineDetector> detector_;
};

/// Largest distance of the segment's ends from the infinite line through a and b.
[[nodiscard]] inline double off_line_px(const Segment& segment, const Eigen::Vector2d& a,
                                        const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = (b - a).normalized();
  const Eigen::Vector2d n(d.y(), -d.x());
  return std::max(std::abs(n.dot(segment.start() - a)), std::abs(n.dot(segment.end() - a)));
}

/// Larger distance of the segment's ends from a and b, in this order.
[[nodiscard]] inline double off_ends_px(const Segment& segment, const Eigen::Vector2d& a,
                                        const Eigen::Vector2d& b) {
  return std::max((segment.start() - a).norm(), (segment.end() - b).norm());
}

}  // namespace pled::support
