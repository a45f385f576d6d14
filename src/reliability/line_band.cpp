#include "pled_vins/reliability/line_band.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pled_vins/reliability/event_count.hpp"

namespace pled {
namespace {

constexpr double kLeastLength_px = 1e-6;
constexpr double kFarthest_px = 1e6;
/// Pixels that rounding alone puts outside belong to the band.
constexpr double kRounding_px = 1e-9;

/// A segment by the axis it goes along more (`a`, growing) and the other (`b`).
struct Course {
  bool steep = false;  ///< a is y
  Eigen::Vector2d start;
  Eigen::Vector2d direction;  ///< unit
  double length_px = 0.0;
};

std::optional<Course> course_of(Eigen::Vector2d start, Eigen::Vector2d end) noexcept {
  const auto near = [](const Eigen::Vector2d& p) {
    return std::abs(p.x()) < kFarthest_px && std::abs(p.y()) < kFarthest_px;
  };
  if (!near(start) || !near(end)) return std::nullopt;
  Course course;
  course.steep = std::abs(end.y() - start.y()) > std::abs(end.x() - start.x());
  if (course.steep) {
    std::swap(start.x(), start.y());
    std::swap(end.x(), end.y());
  }
  if (start.x() > end.x()) std::swap(start, end);
  course.start = start;
  course.length_px = (end - start).norm();
  if (!(course.length_px > kLeastLength_px)) return std::nullopt;
  course.direction = (end - start) / course.length_px;
  return course;
}

/// Whole numbers in [from, to], held in [0, size).
struct Steps {
  int first = 0;
  int last = -1;
};
Steps whole_numbers(double from, double to, int size) noexcept {
  return {std::max(0, static_cast<int>(std::ceil(from - kRounding_px))),
          std::min(size - 1, static_cast<int>(std::floor(to + kRounding_px)))};
}

/// Sums over the pixels of one band.
class BandReader {
 public:
  BandReader(const AnchoredMap& map, BinNumber last, ScoreForm form) noexcept
      : map_(map), last_(last), form_(form), empty_(map.tables().score({}, form)) {}

  void add(int x_px, int y_px, double offset_px) noexcept {
    const BinCounts counts = map_.counts_at(x_px, y_px, last_);
    const std::uint32_t n = total(counts);
    if (n == 0 && form_ == ScoreForm::kClean) return;
    const double w = std::exp(-0.5 * offset_px * offset_px / (kBandSigma_px * kBandSigma_px));
    weights_ += w;
    s_ += w * (n == 0 ? empty_.s : map_.tables().score(counts, form_).s);
    reliability_ += w * event_count_reliability(n);
    ++out_.pixels;
    out_.with_events += n > 0 ? 1 : 0;
    add_slope(0, {x_px - 1, y_px}, {x_px + 1, y_px});
    add_slope(1, {x_px, y_px - 1}, {x_px, y_px + 1});
  }

  [[nodiscard]] std::optional<LineBand> mean() const noexcept {
    const std::uint32_t fewest = form_ == ScoreForm::kClean ? kFewestBandPixels : 1;
    if (out_.pixels < fewest) return std::nullopt;
    LineBand band = out_;
    band.s = s_ / weights_;
    band.count_reliability = reliability_ / weights_;
    for (int k = 0; k < 2; ++k)
      if (slopes_[k] > 0) band.gradient[k] = slope_sums_[k] / slopes_[k];
    return band;
  }

 private:
  [[nodiscard]] static std::uint32_t total(const BinCounts& counts) noexcept {
    return std::accumulate(counts.begin(), counts.end(), std::uint32_t{0});
  }

  void add_slope(int axis, const Eigen::Vector2i& before, const Eigen::Vector2i& after) noexcept {
    const BinCounts a = map_.counts_at(before.x(), before.y(), last_);
    const BinCounts b = map_.counts_at(after.x(), after.y(), last_);
    const bool has_a = total(a) > 0;
    const bool has_b = total(b) > 0;
    if (form_ == ScoreForm::kClean && !(has_a && has_b)) return;
    const double q_a = has_a ? map_.tables().recency(a, form_) : empty_.q;
    const double q_b = has_b ? map_.tables().recency(b, form_) : empty_.q;
    slope_sums_[axis] += 0.5 * (q_b - q_a);
    slopes_[axis] += 1.0;
  }

  const AnchoredMap& map_;
  BinNumber last_;
  ScoreForm form_;
  PixelScore empty_;
  LineBand out_;
  double weights_ = 0.0;
  double s_ = 0.0;
  double reliability_ = 0.0;
  Eigen::Vector2d slope_sums_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d slopes_ = Eigen::Vector2d::Zero();
};

}  // namespace

std::optional<LineBand> read_line_band(const AnchoredMap& map, BinNumber last,
                                       const Eigen::Vector2d& start_px,
                                       const Eigen::Vector2d& end_px, ScoreForm form) noexcept {
  const std::optional<Course> course = course_of(start_px, end_px);
  if (!course) return std::nullopt;
  const Eigen::Vector2d& v = course->direction;
  const int columns = course->steep ? map.height_px() : map.width_px();
  const int rows = course->steep ? map.width_px() : map.height_px();
  constexpr double kHalf_px = 0.5 * kBandWidth_px;
  const double beyond = kHalf_px * std::abs(v.y());  // the corners of the band's ends
  const Steps along = whole_numbers(
      course->start.x() - beyond, course->start.x() + course->length_px * v.x() + beyond, columns);
  const int stride = (along.last - along.first) / kMaxBandColumns + 1;
  BandReader reader(map, last, form);
  for (int a = along.first; a <= along.last; a += stride) {
    const double middle = course->start.y() + (a - course->start.x()) * v.y() / v.x();
    const Steps across = whole_numbers(middle - kHalf_px / v.x(), middle + kHalf_px / v.x(), rows);
    for (int b = across.first; b <= across.last; ++b) {
      const Eigen::Vector2d from_start = Eigen::Vector2d(a, b) - course->start;
      const double s = v.dot(from_start);
      if (!(s >= -kRounding_px && s <= course->length_px + kRounding_px)) continue;
      const double offset_px = v.x() * from_start.y() - v.y() * from_start.x();
      reader.add(course->steep ? b : a, course->steep ? a : b, offset_px);
    }
  }
  return reader.mean();
}

}  // namespace pled
