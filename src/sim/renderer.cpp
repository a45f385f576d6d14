#include "src/sim/renderer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

namespace pled::sim {
namespace {

/// Light from above: factor for faces -x +x -y +y -z +z.
constexpr std::array<float, 6> kBoxLight{0.85F, 0.75F, 0.65F, 0.9F, 0.4F, 1.0F};
constexpr std::array<float, 6> kRoomLight{0.85F, 0.95F, 0.8F, 0.9F, 0.75F, 0.9F};

constexpr float kHeadlightReach_m = 8.0F;
constexpr float kLampRadiance = 0.6F;

constexpr float kFar = std::numeric_limits<float>::max();

}  // namespace

Result<Renderer> Renderer::create(const World& world, const CameraCalibration& calibration) {
  if (world.boxes.size() > kMaxBoxes) return ErrorCode::kTooLarge;
  Renderer r;
  r.world_ = &world;
  r.width_ = calibration.width_px;
  r.height_ = calibration.height_px;
  PLED_TRY(r.make_rays(calibration));
  r.make_tiles();
  return r;
}

Result<void> Renderer::make_rays(const CameraCalibration& calibration) {
  constexpr std::array<std::array<double, 2>, kSubRays + 1> kOffsets{
      {{-0.25, -0.25}, {0.25, -0.25}, {-0.25, 0.25}, {0.25, 0.25}, {0.0, 0.0}}};
  const Camera camera{calibration};
  for (std::size_t k = 0; k <= kSubRays; ++k) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const Eigen::Vector2d raw_px{x + kOffsets[k][0], y + kOffsets[k][1]};
        const std::optional<Eigen::Vector2d> xy = camera.undistort(raw_px);
        if (!xy) return ErrorCode::kInvalidArgument;
        Eigen::Matrix2d d_px_d_xy;
        (void)camera.distort(*xy, d_px_d_xy);
        const double area = 1.0 / std::abs(d_px_d_xy.determinant());
        rays_[k].push_back({xy->cast<float>(), static_cast<float>(xy->homogeneous().norm()),
                            static_cast<float>(area)});
      }
    }
  }
  return {};
}

void Renderer::make_tiles() {
  tiles_per_row_ = static_cast<std::size_t>((width_ + kTilePx - 1) / kTilePx);
  const auto rows = static_cast<std::size_t>((height_ + kTilePx - 1) / kTilePx);
  tiles_.assign(rows * tiles_per_row_, none());
  const auto width = static_cast<std::size_t>(width_);
  for (const std::vector<Ray>& rays : rays_)
    for (std::size_t i = 0; i < rays.size(); ++i)
      tiles_[tile_of(i / width, i % width)].include(rays[i].xy.array());
}

Renderer::Bounds Renderer::none() noexcept {
  return {Eigen::Array2f::Constant(kFar), Eigen::Array2f::Constant(-kFar)};
}

/// Of the part of a box before the camera: its corners there and where its edges come to the front.
Renderer::Bounds Renderer::bounds_of(const Box& box, const Pose& T_cam_box) noexcept {
  constexpr double kFront_m = 0.02;
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector3d signs{(k & 1U) != 0 ? 1.0 : -1.0, (k & 2U) != 0 ? 1.0 : -1.0,
                                (k & 4U) != 0 ? 1.0 : -1.0};
    corners[k] = T_cam_box * box.half_m.cwiseProduct(signs);
  }
  Bounds bounds = none();
  const auto include = [&](const Eigen::Vector3d& p) {
    bounds.include(p.hnormalized().cast<float>().array());
  };
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector3d& a = corners[k];
    if (a.z() >= kFront_m) include(a);
    for (const std::size_t bit : {1U, 2U, 4U}) {
      const Eigen::Vector3d& b = corners[k ^ bit];
      if (a.z() < kFront_m && b.z() > kFront_m)
        include(a + (kFront_m - a.z()) / (b.z() - a.z()) * (b - a));
    }
  }
  return bounds;
}

Renderer::Scene Renderer::place(const Pose& T_world_cam, double t_s) const {
  Scene scene;
  scene.tiles.assign(tiles_.size(), 0);
  for (std::size_t b = 0; b < world_->boxes.size(); ++b) {
    const Box& box = world_->boxes[b];
    const Pose T_box_cam = box.T_world_box(t_s).inverse() * T_world_cam;
    Placed placed;
    placed.R_box_cam << T_box_cam.R().cast<float>(), 0.0F, 0.0F, 1.0F;
    placed.origin << T_box_cam.p.cast<float>(), 0.0F;
    placed.half << box.half_m.cast<float>(), 1e6F;
    placed.box = &box;
    scene.boxes.push_back(placed);

    const Bounds bounds = bounds_of(box, T_box_cam.inverse());
    for (std::size_t k = 0; k < tiles_.size(); ++k)
      if (bounds.overlaps(tiles_[k])) scene.tiles[k] |= BoxMask{1} << b;
  }
  return scene;
}

Renderer::Hit Renderer::cast(const Scene& scene, BoxMask mask, const Ray& ray) noexcept {
  Hit hit;
  hit.depth_m = kFar;
  hit.box = 0;
  hit.face = 0;
  hit.direction = Eigen::Array4f::Zero();
  for (; mask != 0; mask &= mask - 1) {
    const auto b = static_cast<std::size_t>(std::countr_zero(mask));
    const Placed& p = scene.boxes[b];
    const Eigen::Array4f d =
        (p.R_box_cam.col(0) * ray.xy.x() + p.R_box_cam.col(1) * ray.xy.y() + p.R_box_cam.col(2))
            .array();
    // Slabs. A ray parallel to one gives infinities or NaN, which no comparison below takes.
    const Eigen::Array4f inverse = d.inverse();
    const Eigen::Array4f reach = p.half * inverse.abs();
    const Eigen::Array4f middle = -p.origin * inverse;
    const Eigen::Array4f nearest = middle - reach;
    const Eigen::Array4f farthest = middle + reach;
    float enter = -kFar, leave = kFar;
    int enter_axis = 0, leave_axis = 0;
    for (int a = 0; a < 3; ++a) {
      if (nearest(a) > enter) enter = nearest(a), enter_axis = a;
      if (farthest(a) < leave) leave = farthest(a), leave_axis = a;
    }
    const bool inside = p.box->seen_from_inside;
    const float depth = inside ? leave : enter;
    if (!(enter < leave && depth > 0.0F && depth < hit.depth_m)) continue;
    const int axis = inside ? leave_axis : enter_axis;
    hit.depth_m = depth;
    hit.box = static_cast<std::uint8_t>(b);
    hit.face = static_cast<std::uint8_t>(2 * axis + ((d(axis) > 0.0F) == inside ? 1 : 0));
    hit.direction = d;
  }
  return hit;
}

float Renderer::shade(const Scene& scene, const Ray& ray, const Hit& hit) const noexcept {
  const Placed& p = scene.boxes[hit.box];
  const int axis = hit.face / 2;
  const int u_axis = axis == 0 ? 1 : 0;
  const int v_axis = axis == 2 ? 1 : 2;
  const Eigen::Array4f corner = p.origin + hit.depth_m * hit.direction + p.half;
  // A slanted surface is covered by a longer patch than one that faces us: 1 / cos along the
  // slope, 1 across. Ours: averaged over a square of the same area.
  const float cosine = std::max(std::abs(hit.direction(axis)) / ray.length, 0.02F);
  const float area_m2 = hit.depth_m * hit.depth_m * ray.area / cosine;
  const float facing = p.box->seen_from_inside ? kRoomLight[hit.face] : kBoxLight[hit.face];
  const float grey = p.box->faces[hit.face].sample(corner(u_axis), corner(v_axis), area_m2);
  const Light& light = world_->light;
  if (light.headlight <= 0.0F && light.ambient >= 1.0F) return facing * grey;
  // A beam whose middle is where the camera looks, fading with the square of the distance.
  const float off_axis = 1.0F / (ray.length * ray.length);
  const float distance = hit.depth_m * ray.length / kHeadlightReach_m;
  const float beam = light.headlight * cosine * off_axis * off_axis / (1.0F + distance * distance);
  const float lit = grey * (facing * light.ambient + beam);
  const float lamp = std::clamp((grey - kLampFrom) / (1.0F - kLampFrom), 0.0F, 1.0F);
  return lit + lamp * (kLampRadiance - lit);
}

void Renderer::render(const Pose& T_world_cam, double t_s, View& view) const {
  const Scene scene = place(T_world_cam, t_s);
  const std::vector<Ray>& centres = rays_[kSubRays];
  view.radiance.resize(centres.size());
  view.depth_m.resize(centres.size());
  view.surface.resize(centres.size());
  std::size_t i = 0;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x, ++i) {
      const Hit hit = cast(scene, seen(scene, y, x), centres[i]);
      view.radiance[i] = shade(scene, centres[i], hit);
      view.depth_m[i] = hit.depth_m;
      view.surface[i] = static_cast<std::uint16_t>(6 * hit.box + hit.face);
    }
  }
  smooth_edges(scene, view);
}

void Renderer::smooth_edges(const Scene& scene, View& view) const {
  const auto width = static_cast<std::size_t>(width_);
  const auto height = static_cast<std::size_t>(height_);
  const std::vector<std::uint16_t>& s = view.surface;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t i = y * width + x;
      const bool edge = (x > 0 && s[i - 1] != s[i]) || (x + 1 < width && s[i + 1] != s[i]) ||
                        (y > 0 && s[i - width] != s[i]) || (y + 1 < height && s[i + width] != s[i]);
      if (!edge) continue;
      float sum = 0.0F;
      for (std::size_t k = 0; k < kSubRays; ++k) {
        const Ray& ray = rays_[k][i];
        sum += shade(scene, ray, cast(scene, seen(scene, y, x), ray));
      }
      view.radiance[i] = sum / static_cast<float>(kSubRays);
    }
  }
}

}  // namespace pled::sim
