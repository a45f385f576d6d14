#include "src/sim/painter.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

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

  /// One grey; 1 is a lamp.
  void panel(const Patch& p, double grey) {
    each_texel(p, [grey](double, double) { return grey; });
  }

  void disc(double u_m, double v_m, double radius_m, double grey) {
    each_texel({u_m, v_m, radius_m, radius_m},
               [&](double du, double dv) { return std::hypot(du, dv) < radius_m ? grey : kKeep; });
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

  /// Light and dark bars of `width_m` along the patch's second axis.
  void bars(const Patch& p, double width_m, double dark, double light) {
    each_texel(p, [&](double du, double) {
      return static_cast<std::int64_t>(std::floor(du / width_m)) % 2 == 0 ? dark : light;
    });
  }

  [[nodiscard]] double texel_m() const noexcept { return static_cast<double>(texture_.texel_m()); }

 private:
  static constexpr double kKeep = -1.0;  ///< a shade that leaves what is there
  void set(int y, int x, double grey) noexcept {
    if (grey == kKeep) return;
    texture_.at(y, x) = grey == 1.0 ? 1.0F : static_cast<float>(std::clamp(grey, 0.03, 0.95));
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

/// Storeys of windows, some lit or curtained, above a row of signs.
void facade(Painter& painter) {
  painter.ground(painter.random().uniform(0.25, 0.6), 0.10, 1.2, 5);
  painter.tiles(1.1, 0.35, 0.12, 0.03);
  const double step_u_m = painter.random().uniform(1.8, 2.6);
  const double step_v_m = painter.random().uniform(2.8, 3.3);
  for (double v = 4.2; v + 1.0 < painter.height_m(); v += step_v_m) {
    for (double u = 1.2; u + 0.8 < painter.width_m(); u += step_u_m) {
      const double grey = painter.random().uniform() < 0.25 ? painter.random().uniform(0.5, 0.9)
                                                            : painter.random().uniform(0.03, 0.2);
      painter.panel({u, v, 0.62, 0.85}, 0.8);
      painter.panel({u, v, 0.52, 0.75}, grey);
      painter.panel({u, v, 0.03, 0.75}, 0.75);
    }
  }
  for (double u = 1.0; u < painter.width_m(); u += painter.random().uniform(1.2, 2.6)) {
    Patch sign{u, painter.random().uniform(1.0, 2.6), painter.random().uniform(0.3, 0.8),
               painter.random().uniform(0.3, 0.9)};
    painter.poster(sign);
  }
}

/// Dark ground with patches, bays marked in white, dashes and stains.
void asphalt(Painter& painter) {
  painter.ground(0.24, 0.06, 1.5, 6);
  Random& random = painter.random();
  for (int k = 0; k < 90; ++k) {
    const Patch p = painter.random_patch(0.5, 3.0, 0.6);
    painter.panel(p, random.uniform(0.10, 0.34));
  }
  for (int k = 0; k < 160; ++k)
    painter.panel(painter.random_patch(0.1, 0.5, 1.5), random.uniform(0.05, 0.5));
  for (double v = 2.0; v < painter.height_m(); v += 8.2)
    for (double u = 0.5; u < painter.width_m(); u += 2.56) {
      painter.panel({u, v, 0.06, 2.3}, random.uniform(0.7, 0.85));
      painter.panel({u + 1.2, v + 4.4, 0.6, 0.07}, random.uniform(0.7, 0.85));
    }
}

void car_side(Painter& painter) {
  const double paint_grey = painter.random().uniform(0.08, 0.85);
  const double w = painter.width_m(), h = painter.height_m();
  painter.ground(paint_grey, 0.03, 0.6, 2);
  for (const double u : {0.34, 0.52, 0.70})
    painter.panel({u * w, 0.55 * h, 0.012, 0.45 * h}, 0.4 * paint_grey);
  painter.panel({0.5 * w, 0.12 * h, 0.5 * w, 0.08 * h}, 0.06);
  painter.panel({0.42 * w, 0.72 * h, 0.07, 0.02}, 0.9);
  for (const double u : {0.18, 0.82}) {
    painter.disc(u * w, 0.32 * h, 0.36 * h, 0.05);
    painter.disc(u * w, 0.32 * h, 0.2 * h, 0.6);
    painter.disc(u * w, 0.32 * h, 0.08 * h, 0.1);
  }
}

void car_end(Painter& painter) {
  const double w = painter.width_m(), h = painter.height_m();
  painter.ground(painter.random().uniform(0.1, 0.8), 0.03, 0.5, 2);
  painter.panel({0.5 * w, 0.2 * h, 0.5 * w, 0.12 * h}, 0.08);
  painter.panel({0.5 * w, 0.45 * h, 0.26, 0.06}, 0.85);
  painter.panel({0.5 * w, 0.66 * h, 0.25 * w, 0.1 * h}, 0.12);
  for (const double u : {0.12, 0.88}) painter.panel({u * w, 0.66 * h, 0.12, 0.07}, 1.0);
}

/// Posters at random until they cover `cover` times the area.
void posters(Painter& painter, double cover, double low_m, double high_m, double turn_rad) {
  const double wanted_m2 = cover * painter.width_m() * painter.height_m();
  for (double area_m2 = 0.0; area_m2 < wanted_m2;) {
    const Patch p = painter.random_patch(low_m, high_m, turn_rad);
    painter.poster(p);
    area_m2 += 4.0 * p.half_w_m * p.half_h_m;
  }
}

void bus_side(Painter& painter) {
  const double w = painter.width_m(), h = painter.height_m();
  painter.ground(0.55, 0.05, 0.4, 3);
  for (double u = 0.6; u + 0.6 < w; u += 1.2) {
    const double glass = painter.random().uniform(0.05, 0.2);
    painter.panel({u, 0.68 * h, 0.52, 0.19 * h}, 0.85);
    painter.panel({u, 0.68 * h, 0.46, 0.17 * h}, glass);
  }
  painter.panel({0.5 * w, 0.42 * h, 0.5 * w, 0.03 * h}, 0.1);
  for (double u = 0.5; u < w; u += painter.random().uniform(0.8, 1.6)) {
    Patch notice{u, 0.22 * h, painter.random().uniform(0.2, 0.4),
                 painter.random().uniform(0.15, 0.4)};
    painter.poster(notice);
  }
}

/// Spots over spots until they cover three times the area.
void pebbles(Painter& painter) {
  painter.ground(0.5, 0.1, 20.0 * painter.texel_m(), 3);
  const double wanted_m2 = 3.0 * painter.width_m() * painter.height_m();
  Random& random = painter.random();
  for (double area_m2 = 0.0; area_m2 < wanted_m2;) {
    const double radius_m = painter.texel_m() * std::exp(random.uniform(1.1, 2.3));
    painter.disc(random.uniform(0.0, painter.width_m()), random.uniform(0.0, painter.height_m()),
                 radius_m, random.uniform(0.05, 0.9));
    area_m2 += std::numbers::pi * radius_m * radius_m;
  }
}

void stripes(Painter& painter) {
  Random& random = painter.random();
  const double wanted_m2 = 4.0 * painter.width_m() * painter.height_m();
  for (double area_m2 = 0.0; area_m2 < wanted_m2;) {
    const Patch p = painter.random_patch(60.0 * painter.texel_m(), 200.0 * painter.texel_m(), 1.5);
    painter.bars(p, painter.texel_m() * random.uniform(5.0, 12.0), random.uniform(0.05, 0.3),
                 random.uniform(0.6, 0.9));
    area_m2 += 4.0 * p.half_w_m * p.half_h_m;
  }
}

}  // namespace

Texture make_texture(Finish finish, double width_m, double height_m, double texel_m) {
  if (finish == Finish::kAsphalt) return Texture::repeating(2048, 0.02);
  if (finish == Finish::kFacade || finish == Finish::kPavement) texel_m = std::max(texel_m, 0.03);
  if (finish == Finish::kSkyline) texel_m = std::max(texel_m, 0.12);
  if (finish == Finish::kSky) texel_m = std::max(texel_m, 0.5);
  return Texture{width_m, height_m, texel_m};
}

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
    case Finish::kAsphalt: asphalt(painter); break;
    case Finish::kPavement:
      painter.ground(0.42, 0.08, 0.8, 4);
      painter.tiles(0.6, 0.6, 0.3, 0.025);
      break;
    case Finish::kFacade: facade(painter); break;
    case Finish::kSkyline:
      painter.ground(0.45, 0.10, 9.0, 4);
      painter.tiles(7.0, 60.0, 0.5, 0.3);
      posters(painter, 0.5, 1.0, 3.0, 0.0);
      break;
    case Finish::kSky: painter.ground(0.85, 0.05, 40.0, 3); break;
    case Finish::kCarSide: car_side(painter); break;
    case Finish::kCarEnd: car_end(painter); break;
    case Finish::kBusSide: bus_side(painter); break;
    case Finish::kPebbles: pebbles(painter); break;
    case Finish::kStripes: stripes(painter); break;
    case Finish::kCarTop:
      painter.ground(painter.random().uniform(0.08, 0.8), 0.03, 0.8, 2);
      painter.panel(painter.random_patch(0.2, 0.5, 0.2), 0.1);
      break;
    case Finish::kGlass:
      painter.ground(0.10, 0.05, 0.5, 3);
      painter.panel(
          {0.5 * painter.width_m(), 0.5 * painter.height_m(), 0.04, 0.5 * painter.height_m()}, 0.7);
      break;
  }
  texture.build_levels();
}

}  // namespace pled::sim
