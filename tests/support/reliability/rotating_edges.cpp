#include "support/reliability/rotating_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <Eigen/Geometry>

#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/reliability/anchored_map.hpp"

namespace pled::support {
namespace {

constexpr double kCx = (RotatingEdges::kWidth_px - 1) / 2.0;
constexpr double kCy = (RotatingEdges::kHeight_px - 1) / 2.0;
constexpr double kF = RotatingEdges::kFocal_px;
constexpr int kMargin = limits::kMapMargin_px;
constexpr std::int64_t kStep_us = 200;
constexpr std::int64_t kRefractory_us = 500;
constexpr double kOwnRate_radps = 1.0;
constexpr double kAlpha = 2.0;
constexpr double kGridShift_px = 0.49;  // almost half: the nearest pixel is still the same one

Eigen::Vector3d bearing(double x_px, double y_px) {
  return {(x_px - kCx) / kF, (y_px - kCy) / kF, 1.0};
}

/// A point of an edge, far away; one that moves turns about the world's origin by kOwnRate_radps.
struct EdgePoint {
  Eigen::Vector3d direction;
  bool moves = false;
};

std::vector<EdgePoint> edge_points(std::mt19937_64& random) {
  constexpr int kEdges = 60;
  constexpr double kSpread_px = 500.0;  // edges are there for the camera to turn to
  std::uniform_real_distribution<double> place(-kSpread_px, kSpread_px);
  std::uniform_real_distribution<double> length(20.0, 80.0);
  std::uniform_real_distribution<double> angle(0.0, 3.14159);
  std::vector<EdgePoint> points;
  for (int edge = 0; edge < kEdges; ++edge) {
    const Eigen::Vector2d begin(kCx + place(random), kCy + 0.3 * place(random));
    const double a = angle(random);
    const double end = length(random);
    for (double s = 0.0; s < end; s += 0.5) {
      points.push_back(
          {bearing(begin.x() + s * std::cos(a), begin.y() + s * std::sin(a)), edge % 4 == 0});
    }
  }
  return points;
}

/// What a pixel scores, alone and as the mean of the active ones of the 3 x 3 around it.
struct Scored {
  const BatchCounts& counts;
  [[nodiscard]] double at(int x, int y) const {
    const auto found = counts.find({x, y});
    return found == counts.end() ? 0.0 : score_by_definition(found->second, kAlpha, 0.0).s;
  }
  [[nodiscard]] double pooled(int x, int y) const {
    double sum = 0.0;
    int active = 0;
    for (int yy = y - 1; yy <= y + 1; ++yy) {
      for (int xx = x - 1; xx <= x + 1; ++xx) {
        active += counts.contains({xx, yy}) ? 1 : 0;
        sum += at(xx, yy);
      }
    }
    return active > 0 ? sum / active : 0.0;
  }
};

Difference summary(std::vector<double>& differences) {
  Difference out;
  out.pixels = differences.size();
  if (differences.empty()) return out;
  std::sort(differences.begin(), differences.end());
  const double n = static_cast<double>(differences.size());
  for (const double d : differences) {
    out.mean += d / n;
    out.above_tenth += d > 0.1 ? 1.0 / n : 0.0;
  }
  out.p90 = differences[differences.size() * 9 / 10];
  return out;
}

}  // namespace

RotatingEdges::RotatingEdges(const Eigen::Vector3d& rate_radps, Duration length, std::uint64_t seed)
    : rate_radps_(rate_radps) {
  std::mt19937_64 random(seed);
  const std::vector<EdgePoint> points = edge_points(random);
  // An edge fires each time one of its points has moved on by a third of a pixel.
  constexpr double kThird = 3.0;
  std::vector<Eigen::Vector2i> thirds(points.size());
  std::vector<std::int64_t> last_us(static_cast<std::size_t>(kWidth_px * kHeight_px), -1'000'000);
  for (std::int64_t t_us = 0; t_us < length.us; t_us += kStep_us) {
    const double t_s = static_cast<double>(t_us) * 1e-6;
    const Eigen::Matrix3d R_cam_world = so3::exp(-rate_radps_ * t_s).toRotationMatrix();
    const Eigen::Matrix3d R_cam_moving =
        R_cam_world * so3::exp({0.0, kOwnRate_radps * t_s, 0.0}).toRotationMatrix();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const EdgePoint& point = points[i];
      const Eigen::Vector3d b = (point.moves ? R_cam_moving : R_cam_world) * point.direction;
      const double x = kF * b.x() / b.z() + kCx;
      const double y = kF * b.y() / b.z() + kCy;
      const Eigen::Vector2i third(static_cast<int>(std::floor(x * kThird)),
                                  static_cast<int>(std::floor(y * kThird)));
      const bool moved = t_us > 0 && third != thirds[i];
      thirds[i] = third;
      const int px = static_cast<int>(std::floor(x + 0.5));
      const int py = static_cast<int>(std::floor(y + 0.5));
      if (!moved || !(b.z() > 0.2) || px < 0 || py < 0 || px >= kWidth_px || py >= kHeight_px)
        continue;
      std::int64_t& last = last_us[static_cast<std::size_t>(py * kWidth_px + px)];
      if (t_us - last < kRefractory_us) continue;
      last = t_us;
      events_.push_back({{t_us}, {static_cast<std::int16_t>(px), static_cast<std::int16_t>(py)}});
    }
  }
}

Eigen::Vector2d RotatingEdges::carry(const Eigen::Vector2d& sensor_px, Timestamp t_from,
                                     Timestamp t_to) const {
  const Eigen::Vector3d b =
      so3::exp(rate_radps_ * (t_from - t_to).seconds()) * bearing(sensor_px.x(), sensor_px.y());
  return {kF * b.x() / b.z() + kCx + kMargin, kF * b.y() / b.z() + kCy + kMargin};
}

WarpedPixel RotatingEdges::warp(const TimedPixel& event, Timestamp t_to, double shift_px) const {
  const Eigen::Vector2d at = carry({event.at.x_px, event.at.y_px}, event.t, t_to);
  return {static_cast<std::int16_t>(std::floor(at.x() + shift_px + 0.5)),
          static_cast<std::int16_t>(std::floor(at.y() + shift_px + 0.5))};
}

double RotatingEdges::shift_px(Timestamp t_from, Timestamp t_to) const {
  const Eigen::Vector2d centre(kCx, kCy);
  return (carry(centre, t_from, t_to) - carry(centre, t_from, t_from)).norm();
}

namespace {

constexpr int kGridW = RotatingEdges::kGridWidth_px;
constexpr int kGridH = RotatingEdges::kGridHeight_px;

class Comparer {
 public:
  explicit Comparer(const RotatingEdges& scene) : scene_(scene) {}

  /// Hands the map all events up to a frame that is known beforehand, and compares there.
  void play_to(Timestamp t_frame, Timestamp t_before) {
    clock_.expect_frame(t_frame, t_before);
    for (; next_ < scene_.events().size() && scene_.events()[next_].t <= t_frame; ++next_)
      take(scene_.events()[next_]);
    compare(t_frame, clock_.on_frame(t_frame));
  }

  [[nodiscard]] RewarpComparison result() {
    return {summary(one_[0]),    summary(one_[1]), summary(pooled_[0]),
            summary(pooled_[1]), beyond_grid_,     map_.anchors()};
  }

 private:
  void take(const TimedPixel& event) {
    const TimeBin bin = clock_.bin_of(event.t);
    if (bin.number > begun_) {
      const std::optional<Timestamp> reference = map_.reference();
      map_.begin_bin(bin.number, bin.begin,
                     reference ? scene_.shift_px(*reference, bin.begin) : 0.0);
      begun_ = bin.number;
    }
    for (const AnchorTarget& target : map_.targets()) {
      const WarpedPixel at = scene_.warp(event, target.t_reference);
      map_.add(target, {&at, 1}, bin.number);
    }
  }

  [[nodiscard]] BatchCounts rewarp(Timestamp t_frame, double shift_px) const {
    std::vector<TimedPixel> warped;
    for (std::size_t k = next_; k-- > 0;) {
      const TimedPixel& event = scene_.events()[k];
      if ((t_frame - event.t).us >= static_cast<std::int64_t>(kB) * kWidth.us) break;
      warped.push_back({event.t, scene_.warp(event, t_frame, shift_px)});
    }
    return batch_counts(warped, t_frame, kWidth);
  }

  void compare(Timestamp t_frame, BinNumber last) {
    const BatchCounts batch = rewarp(t_frame, 0.0);
    const BatchCounts moved = rewarp(t_frame, kGridShift_px);
    const Scored exact{batch};
    const Scored other{moved};
    for (const auto& [at, counts] : batch) {
      const auto [x, y] = at;
      const Eigen::Vector2d sensor_px(x - kMargin, y - kMargin);
      if (sensor_px.x() < 0 || sensor_px.y() < 0 || sensor_px.x() >= RotatingEdges::kWidth_px ||
          sensor_px.y() >= RotatingEdges::kHeight_px)
        continue;
      const Eigen::Vector2d p = scene_.carry(sensor_px, t_frame, map_.reference().value());
      if (!(p.x() > 0 && p.y() > 0 && p.x() < kGridW - 1 && p.y() < kGridH - 1)) {
        ++beyond_grid_;
        continue;
      }
      const auto one = map_.read(p.x(), p.y(), last);
      const auto nine = map_.read(p.x(), p.y(), last, ScorePooling::kMeanActive);
      one_[0].push_back(std::abs(exact.at(x, y) - (one ? one->s : 0.0)));
      one_[1].push_back(std::abs(exact.at(x, y) - other.at(x, y)));
      pooled_[0].push_back(std::abs(exact.pooled(x, y) - (nine ? nine->s : 0.0)));
      pooled_[1].push_back(std::abs(exact.pooled(x, y) - other.pooled(x, y)));
    }
  }

  static constexpr Duration kWidth{ReliabilityConfig{}.bin_us};

  const RotatingEdges& scene_;
  std::vector<BinCell> a_ = std::vector<BinCell>(BinCounters::cells_needed(kGridW, kGridH));
  std::vector<BinCell> b_ = a_;
  AnchoredMap map_{ReliabilityConfig{}, kGridW, kGridH, {{a_, b_}}};
  BinClock clock_{kWidth};
  BinNumber begun_ = std::numeric_limits<BinNumber>::min();
  std::size_t next_ = 0;
  /// Differences from the re-warp: of the anchored map, and of the re-warp with its grid moved.
  std::array<std::vector<double>, 2> one_, pooled_;
  std::size_t beyond_grid_ = 0;
};

}  // namespace

RewarpComparison compare_with_rewarp(const RotatingEdges& scene, Duration length,
                                     std::int64_t frame_period_us) {
  Comparer comparer(scene);
  for (std::int64_t t_us = frame_period_us; t_us <= length.us; t_us += frame_period_us)
    comparer.play_to({t_us}, {t_us - frame_period_us});
  return comparer.result();
}

}  // namespace pled::support
