#include "src/sim/painter.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pled::sim {
namespace {

/// A rectangle in metres on the surface, turned by an angle.
struct Patch {
  double u_m = 0, v_m = 0;  // centre
  double half_w_m = 0, half_h_m = 0;
  double cosine = 1, sine = 0;
};

double lattice(std::uint64_t seed, std::int64_t x, std::int64_t y) noexcept {
  const auto ux = static_cast<std::uint64_t>(x);
  const auto uy = static_cast<std::uint64_t>(y);
  const std::uint64_t h = mix(seed + ux * 0x9e3779b97f4a7c15ULL + uy * 0xc2b2ae3d27d4eb4fULL);
  return static_cast<double>(h >> 11U) * 0x1.0p-53;
}

/// Smooth value noise in [-1, 1] with one random value per unit cell; x, y >= 0.
double value_noise(std::uint64_t seed, double x, double y) noexcept {
  const auto x0 = static_cast<std::int64_t>(x);
  const auto y0 = static_cast<std::int64_t>(y);
  double ax = x - static_cast<double>(x0);
  double ay = y - static_cast<double>(y0);
  ax = ax * ax * (3.0 - 2.0 * ax);
  ay = ay * ay * (3.0 - 2.0 * ay);
  const double top = std::lerp(lattice(seed, x0, y0), lattice(seed, x0 + 1, y0), ax);
  const double bottom = std::lerp(lattice(seed, x0, y0 + 1), lattice(seed, x0 + 1, y0 + 1), ax);
  return 2.0 * std::lerp(top, bottom, ay) - 1.0;
}

class Painter {
 public:
  Painter(Texture& texture, Random random) : texture_(texture), random_(random) {}

  [[nodiscard]] double width_m() const noexcept { return texture_.width() * texel_m(); }
  [[nodiscard]] double height_m() const noexcept { return texture_.height() * texel_m(); }
  [[nodiscard]] Random& random() noexcept { return random_; }

  /// Fills everything: `grey` and noise whose cells halve from `cell_m` on.
  void ground(double grey, double amplitude, double cell_m, int octaves) {
    const std::uint64_t seed = random_.next();
    for (int y = 0; y < texture_.height(); ++y) {
      for (int x = 0; x < texture_.width(); ++x) {
        double scale = texel_m() / cell_m;
        double weight = amplitude;
        double sum = grey;
        for (int k = 0; k < octaves; ++k, scale *= 2.0, weight *= 0.6)
          sum += weight * value_noise(seed + static_cast<std::uint64_t>(k), x * scale, y * scale);
        set(y, x, sum);
      }
    }
  }

  /// Multiplies square cells by random factors and darkens the joints between them.
  void tiles(double cell_u_m, double cell_v_m, double contrast, double joint_m) {
    const std::uint64_t seed = random_.next();
    for (int y = 0; y < texture_.height(); ++y) {
      for (int x = 0; x < texture_.width(); ++x) {
        const double u = x * texel_m() / cell_u_m, v = y * texel_m() / cell_v_m;
        const auto i = static_cast<std::int64_t>(u), j = static_cast<std::int64_t>(v);
        const bool joint = (u - static_cast<double>(i)) * cell_u_m < joint_m ||
                           (v - static_cast<double>(j)) * cell_v_m < joint_m;
        const double factor = 1.0 + contrast * (2.0 * lattice(seed, i, j) - 1.0);
        set(y, x, static_cast<double>(texture_.at(y, x)) * (joint ? 0.45 : factor));
      }
    }
  }

  [[nodiscard]] Patch random_patch(double low_m, double high_m, double max_turn_rad) {
    Patch p;
    p.u_m = random_.uniform(0.0, width_m());
    p.v_m = random_.uniform(0.0, height_m());
    p.half_w_m = 0.5 * random_.uniform(low_m, high_m);
    p.half_h_m = 0.5 * random_.uniform(low_m, high_m);
    const double turn = random_.uniform(-max_turn_rad, max_turn_rad);
    p.cosine = std::cos(turn);
    p.sine = std::sin(turn);
    return p;
  }

  /// A picture with a frame: blocks like print, a chequered board, stripes or rings.
  void poster(const Patch& p) {
    const double paper = random_.uniform(0.06, 0.9);
    const double ink = paper > 0.45 ? random_.uniform(0.04, 0.2) : random_.uniform(0.6, 0.92);
    const double cell_m = std::exp(random_.uniform(std::log(0.05), std::log(0.22)));
    const std::uint64_t kind = random_.next() % 5;
    const std::uint64_t seed = random_.next();
    each_texel(p, [&](double du, double dv) {
      const bool rim = std::abs(du) > p.half_w_m - 0.02 || std::abs(dv) > p.half_h_m - 0.02;
      if (rim) return 1.0 - paper;
      const auto i = static_cast<std::int64_t>(std::floor(du / cell_m));
      const auto j = static_cast<std::int64_t>(std::floor(dv / cell_m));
      switch (kind) {
        case 0: return (i + j) % 2 == 0 ? paper : ink;
        case 1: return i % 2 == 0 ? paper : ink;
        case 2: return std::fmod(std::hypot(du, dv), 2.0 * cell_m) < cell_m ? paper : ink;
        default: return std::lerp(paper, ink, std::round(2.0 * lattice(seed, i, j)) * 0.5);
      }
    });
  }

 private:
  [[nodiscard]] double texel_m() const noexcept { return static_cast<double>(texture_.texel_m()); }
  void set(int y, int x, double grey) noexcept {
    texture_.at(y, x) = static_cast<float>(std::clamp(grey, 0.03, 0.95));
  }

  template <typename Shade>
  void each_texel(const Patch& p, const Shade& shade) {
    const double reach_m = std::hypot(p.half_w_m, p.half_h_m);
    const int x0 = std::max(0, static_cast<int>((p.u_m - reach_m) / texel_m()));
    const int y0 = std::max(0, static_cast<int>((p.v_m - reach_m) / texel_m()));
    const int x1 = std::min(texture_.width() - 1, static_cast<int>((p.u_m + reach_m) / texel_m()));
    const int y1 = std::min(texture_.height() - 1, static_cast<int>((p.v_m + reach_m) / texel_m()));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double u = (x + 0.5) * texel_m() - p.u_m, v = (y + 0.5) * texel_m() - p.v_m;
        const double du = p.cosine * u + p.sine * v, dv = p.cosine * v - p.sine * u;
        if (std::abs(du) < p.half_w_m && std::abs(dv) < p.half_h_m) set(y, x, shade(du, dv));
      }
    }
  }

  Texture& texture_;
  Random random_;
};

/// Posters at random until they cover `cover` times the area.
void posters(Painter& painter, double cover, double low_m, double high_m, double turn_rad) {
  const double wanted_m2 = cover * painter.width_m() * painter.height_m();
  for (double area_m2 = 0.0; area_m2 < wanted_m2;) {
    const Patch p = painter.random_patch(low_m, high_m, turn_rad);
    painter.poster(p);
    area_m2 += 4.0 * p.half_w_m * p.half_h_m;
  }
}

}  // namespace

void paint(Texture& texture, Finish finish, Random random) {
  Painter painter{texture, random};
  switch (finish) {
    case Finish::kWall:
      painter.ground(0.5, 0.12, 0.8, 5);
      painter.tiles(0.50, 0.25, 0.25, 0.015);
      posters(painter, 0.55, 0.25, 1.0, 0.12);
      break;
    case Finish::kFloor:
      painter.ground(0.36, 0.10, 0.5, 5);
      painter.tiles(0.40, 0.40, 0.45, 0.02);
      posters(painter, 0.25, 0.4, 1.4, 0.8);
      break;
    case Finish::kCeiling:
      painter.ground(0.62, 0.10, 0.6, 4);
      painter.tiles(0.60, 0.60, 0.25, 0.03);
      posters(painter, 0.15, 0.2, 0.6, 0.0);
      break;
    case Finish::kCrate:
      painter.ground(0.42, 0.14, 0.15, 4);
      painter.tiles(0.60, 0.12, 0.35, 0.012);
      posters(painter, 0.35, 0.12, 0.4, 0.2);
      break;
    case Finish::kCloth:
      painter.ground(0.30, 0.10, 0.10, 3);
      painter.tiles(0.12, 0.18, 0.6, 0.02);
      posters(painter, 0.4, 0.12, 0.35, 0.5);
      break;
  }
  texture.build_levels();
}

}  // namespace pled::sim
