#include "pled_vins/frontend/lines/edge_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace pled {
namespace {

constexpr double kSide_px = 1.5;
constexpr double kMinSlope = 1.0;  // grey/px
constexpr int kLooks = 7;
constexpr double kNeutralGrey = 128.0;

constexpr std::size_t kMaxPlaces = 32;
constexpr int kMinPlaces = 8;
constexpr double kPlaceEvery_px = 3.0;
constexpr int kSearch_px = 2;
constexpr double kStray_px = 1.0;

/// A place on the edge: u in [-1, 1] along the segment, e px along its normal.
struct Place {
  double u = 0.0;
  double e = 0.0;
};

struct Places {
  std::array<Place, kMaxPlaces> at;
  std::size_t count = 0;
};

template <typename Pixel>
bool inside(const ImageView<const Pixel>& image, const Eigen::Vector2d& px) noexcept {
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= image.width - 1 && px.y() <= image.height - 1;
}

double grey_at(const ImageView<const std::uint8_t>& picture, const Eigen::Vector2d& px) noexcept {
  const int x = std::min(static_cast<int>(px.x()), picture.width - 2);
  const int y = std::min(static_cast<int>(px.y()), picture.height - 2);
  const double fx = px.x() - x;
  const double fy = px.y() - y;
  return (1 - fy) * ((1 - fx) * picture.at(y, x) + fx * picture.at(y, x + 1)) +
         fy * ((1 - fx) * picture.at(y + 1, x) + fx * picture.at(y + 1, x + 1));
}

/// The raw pixel at a flat one and the unit vector there that runs along `normal`.
struct Crossing {
  Eigen::Vector2d px;
  Eigen::Vector2d across;
};

std::optional<Crossing> crossing_at(const FlatPixels& flat, const Eigen::Vector2d& flat_px,
                                    const Eigen::Vector2d& normal) noexcept {
  const std::optional<Eigen::Vector2d> here = flat.to_raw(flat_px);
  const std::optional<Eigen::Vector2d> beyond = flat.to_raw(flat_px + normal);
  if (!here || !beyond) return std::nullopt;
  const Eigen::Vector2d step = *beyond - *here;
  const double length = step.norm();
  if (!(length > 1e-3)) return std::nullopt;
  return Crossing{*here, step / length};
}

/// Where along the crossing grey rises most, in px from its middle; parabola through three slopes.
std::optional<double> steepest(const ImageView<const GradientPixel>& gradient,
                               const Crossing& crossing) noexcept {
  std::array<double, 2 * kSearch_px + 3> slope;  // one more on each side for the parabola
  for (int t = -kSearch_px - 1; t <= kSearch_px + 1; ++t) {
    const Eigen::Vector2d px = crossing.px + t * crossing.across;
    if (!inside(gradient, px)) return std::nullopt;
    slope[static_cast<std::size_t>(t + kSearch_px + 1)] =
        gradient_at(gradient, px).dot(crossing.across) / kSobelUnit;
  }
  std::size_t best = 1;
  for (std::size_t i = 2; i + 1 < slope.size(); ++i)
    if (slope[i] > slope[best]) best = i;
  const double before = slope[best - 1];
  const double after = slope[best + 1];
  if (!(slope[best] >= kMinSlope) || before > slope[best] || after > slope[best])
    return std::nullopt;
  const double bend = 2.0 * slope[best] - before - after;
  const double part = bend > 0.0 ? 0.5 * (after - before) / bend : 0.0;
  return static_cast<double>(best) - kSearch_px - 1 + part;
}

Places places_on_edge(const ImageView<const GradientPixel>& gradient, const FlatPixels& flat,
                      const Segment& segment, int wanted) noexcept {
  const Eigen::Vector2d start = segment.start();
  const Eigen::Vector2d along = segment.end() - start;
  const Eigen::Vector2d normal = segment.normal();
  Places places;
  for (int i = 0; i < wanted; ++i) {
    const double share = (i + 0.5) / wanted;
    const std::optional<Crossing> crossing = crossing_at(flat, start + share * along, normal);
    if (!crossing) continue;
    const std::optional<double> t = steepest(gradient, *crossing);
    if (!t) continue;
    const std::optional<Eigen::Vector2d> edge = flat.from_raw(crossing->px + *t * crossing->across);
    if (!edge) continue;
    places.at[places.count++] = {2.0 * share - 1.0, normal.dot(*edge - start)};
  }
  return places;
}

/// e = c0 + c1 u + c2 u^2 by least squares over three places or more that differ.
Eigen::Vector3d parabola(const Places& places) noexcept {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < places.count; ++i) {
    const Place& p = places.at[i];
    const Eigen::Vector3d basis(1.0, p.u, p.u * p.u);
    A += basis * basis.transpose();
    b += p.e * basis;
  }
  return A.ldlt().solve(b);
}

/// e = c0 + c1 u.
Eigen::Vector2d straight(const Places& places) noexcept {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < places.count; ++i) {
    const Place& p = places.at[i];
    const Eigen::Vector2d basis(1.0, p.u);
    A += basis * basis.transpose();
    b += p.e * basis;
  }
  return A.inverse() * b;
}

Places without_strays(const Places& places) noexcept {
  const Eigen::Vector3d c = parabola(places);
  Places kept;
  for (std::size_t i = 0; i < places.count; ++i) {
    const Place& p = places.at[i];
    if (std::abs(p.e - c(0) - c(1) * p.u - c(2) * p.u * p.u) <= kStray_px)
      kept.at[kept.count++] = p;
  }
  return kept;
}

}  // namespace

bool look_across(ImageView<const std::uint8_t> picture, LinePicture kind, const FlatPixels& flat,
                 Segment& segment) noexcept {
  const Eigen::Vector2d normal = segment.normal();
  double along_normal = 0.0;
  double against = 0.0;
  int looks = 0;
  for (int i = 0; i < kLooks; ++i) {
    const Eigen::Vector2d at =
        segment.start() + (i + 0.5) / kLooks * (segment.end() - segment.start());
    const std::optional<Crossing> crossing = crossing_at(flat, at, normal);
    if (!crossing) continue;
    const Eigen::Vector2d ahead = crossing->px + kSide_px * crossing->across;
    const Eigen::Vector2d behind = crossing->px - kSide_px * crossing->across;
    if (!inside(picture, ahead) || !inside(picture, behind)) continue;
    along_normal += grey_at(picture, ahead);
    against += grey_at(picture, behind);
    ++looks;
  }
  const double slope = (along_normal - against) / (2.0 * kSide_px * looks);
  if (looks == 0 || !(std::abs(slope) >= kMinSlope)) return false;
  if (slope < 0.0) {
    std::swap(segment.start_px, segment.end_px);
    std::swap(along_normal, against);
  }
  segment.steepness = static_cast<float>(std::abs(slope));
  segment.active_is_bright =
      kind != LinePicture::kSignedSurface || along_normal + against >= 2.0 * kNeutralGrey * looks;
  return true;
}

std::optional<FittedEdge> fit_edge(ImageView<const GradientPixel> gradient, const FlatPixels& flat,
                                   const Segment& segment) noexcept {
  const double length = segment.length_px();
  const int wanted = static_cast<int>(
      std::clamp(length / kPlaceEvery_px, double{kMinPlaces}, static_cast<double>(kMaxPlaces)));
  const auto least = static_cast<std::size_t>(wanted / 2 + 1);
  const Places found = places_on_edge(gradient, flat, segment, wanted);
  if (found.count < least) return std::nullopt;
  const Places places = without_strays(found);
  if (places.count < least) return std::nullopt;
  const Eigen::Vector2d line = straight(places);
  FittedEdge out{segment, std::abs(parabola(places)(2))};
  const Eigen::Vector2d normal = segment.normal();
  out.segment.set(segment.start() + (line(0) - line(1)) * normal,
                  segment.end() + (line(0) + line(1)) * normal);
  return out;
}

}  // namespace pled
