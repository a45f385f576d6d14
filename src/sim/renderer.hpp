#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/core/result.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "src/sim/world.hpp"

namespace pled::sim {

/// One view, row-major, raw (distorted) pixels.
struct View {
  std::vector<float> radiance;         ///< linear intensity, 0 ... 1
  std::vector<float> depth_m;          ///< z of what the pixel's centre sees, camera frame
  std::vector<std::uint16_t> surface;  ///< 6 x index of its box + face
};

/// Draws the world as a camera sees it, by casting a ray through each pixel.
/// Pictures are averaged over a pixel's footprint and the edges of boxes over four
/// rays, so what a pixel shows changes smoothly with the camera. Safe to call from
/// several threads.
class Renderer {
 public:
  static constexpr std::size_t kMaxBoxes = 64;  ///< a bit each in a tile's mask

  /// kInvalidArgument when a pixel has no ray in the lens model; kTooLarge for more
  /// than kMaxBoxes boxes. `world` must outlive the renderer.
  [[nodiscard]] static Result<Renderer> create(const World& world, const CameraCalibration& camera);

  void render(const Pose& T_world_cam, double t_s, View& view) const;

  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  /// The ray of a pixel's centre, z = 1, camera frame.
  [[nodiscard]] Eigen::Vector2f ray(std::size_t pixel) const noexcept {
    return rays_[kSubRays][pixel].xy;
  }

 private:
  static constexpr std::size_t kSubRays = 4;
  static constexpr int kTilePx = 16;
  struct Ray {
    Eigen::Vector2f xy;
    float length;  // of (x, y, 1)
    float area;    // that the pixel covers on the plane z = 1
  };
  /// Bounds on the plane z = 1 of the camera: of the rays of a square of pixels, or of a box.
  struct Bounds {
    Eigen::Array2f low;
    Eigen::Array2f high;
    void include(const Eigen::Array2f& xy) noexcept {
      low = low.min(xy);
      high = high.max(xy);
    }
    [[nodiscard]] bool overlaps(const Bounds& other) const noexcept {
      return (low <= other.high).all() && (other.low <= high).all();
    }
  };
  /// A box as the camera of this view has it. Fourth lanes only fill up.
  struct Placed {
    Eigen::Matrix<float, 4, 3> R_box_cam;
    Eigen::Array4f origin;  // of the camera, box frame
    Eigen::Array4f half;
    const Box* box;
  };
  struct Hit {
    float depth_m;
    std::uint8_t box;
    std::uint8_t face;
    Eigen::Array4f direction;  // of the ray, box frame
  };
  using BoxMask = std::uint64_t;
  struct Scene {
    std::vector<Placed> boxes;
    std::vector<BoxMask> tiles;  // which boxes a tile may see
  };

  Renderer() = default;
  Result<void> make_rays(const CameraCalibration& calibration);
  void make_tiles();
  [[nodiscard]] Scene place(const Pose& T_world_cam, double t_s) const;
  [[nodiscard]] static Bounds none() noexcept;
  [[nodiscard]] static Bounds bounds_of(const Box& box, const Pose& T_cam_box) noexcept;
  [[nodiscard]] BoxMask seen(const Scene& scene, std::size_t y, std::size_t x) const noexcept {
    return scene.tiles[tile_of(y, x)];
  }
  [[nodiscard]] std::size_t tile_of(std::size_t y, std::size_t x) const noexcept {
    return y / kTilePx * tiles_per_row_ + x / kTilePx;
  }
  [[nodiscard]] static Hit cast(const Scene& scene, BoxMask mask, const Ray& ray) noexcept;
  [[nodiscard]] float shade(const Scene& scene, const Ray& ray, const Hit& hit) const noexcept;
  void smooth_edges(const Scene& scene, View& view) const;

  const World* world_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::size_t tiles_per_row_ = 0;
  std::vector<Bounds> tiles_;
  std::array<std::vector<Ray>, kSubRays + 1> rays_;  // four quarters, then the centres
};

}  // namespace pled::sim
