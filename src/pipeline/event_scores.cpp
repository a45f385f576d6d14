#include "pled_vins/pipeline/event_scores.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace pled {

EventScores::EventScores(const ReliabilityConfig& config, const EventWarp& warp,
                         const CameraCalibration& grid, const AnchoredMapBuffers& buffers) noexcept
    : warp_(warp),
      grid_(grid),
      clock_(Duration{config.bin_us}),
      map_(config, warp.width_px(), warp.height_px(), buffers) {
  const double x = std::max(grid.cx_px, grid.width_px - grid.cx_px) / grid.fx_px;
  const double y = std::max(grid.cy_px, grid.height_px - grid.cy_px) / grid.fy_px;
  stretch_ = mean_focal_px(grid) * (1.0 + x * x + y * y);
}

BinCounterLosses EventScores::losses() const noexcept {
  const BinCounterLosses now = map_.losses();
  return {lost_before_.saturated + now.saturated, lost_before_.late + now.late,
          lost_before_.outside + now.outside};
}

void EventScores::reset() noexcept {
  lost_before_ = losses();
  map_.reset();
  clock_ = BinClock(clock_.width());
  binned_.reset();
}

void EventScores::expect(Timestamp t) noexcept {
  (void)clock_.expect_frame(t, binned_.value_or(t - clock_.width()));
}

void EventScores::on_events(std::span<const Event> events, const TurnHistory& turn) noexcept {
  const std::optional<Timestamp> known = turn.newest();
  while (!events.empty()) {
    // Cut where bins, knots and the gyro end, so that it does not matter how events come.
    const Timestamp first = events.front().t;
    const TimeBin bin = clock_.bin_of(first);
    Timestamp last = std::min(bin.end, Timestamp{first.us | (TurnHistory::kKnot_us - 1)});
    if (known && first <= *known) last = std::min(last, *known);
    std::size_t n = 1;
    while (n < std::min(events.size(), kRun) && events[n].t <= last) ++n;
    add_run(events.first(n), bin, turn);
    binned_ = events[n - 1].t;
    events = events.subspan(n);
  }
}

void EventScores::add_run(std::span<const Event> run, const TimeBin& bin,
                          const TurnHistory& turn) noexcept {
  map_.begin_bin(bin.number, bin.begin, shift_since_anchor_px(bin.begin, turn));
  bool counted = false;
  for (const AnchorTarget& target : map_.targets()) {
    if (!turn.slices(target.t_reference, run.front().t, run.back().t, warp_.slice_error_rad(),
                     slices_))
      continue;
    counted = true;
    const std::span<WarpedPixel> warped = std::span(warped_).first(run.size());
    warp_.warp(run, slices_, warped);
    map_.add(target, warped, bin.number);
  }
  if (!counted) without_turn_ += run.size();
}

/// How far the picture has turned since the map's anchor, where it moved most: a turn by an angle
/// moves a point at tangent r off the axis by up to f (1 + r^2) times it.
double EventScores::shift_since_anchor_px(Timestamp t, const TurnHistory& turn) const noexcept {
  const std::optional<Timestamp> anchor = map_.reference();
  if (!anchor) return 0.0;
  const std::optional<Eigen::Quaterniond> R = turn.rotation(*anchor, t);
  return R ? stretch_ * R->angularDistance(Eigen::Quaterniond::Identity())
           : std::numeric_limits<double>::quiet_NaN();
}

void EventScores::observe(Timestamp t) noexcept {
  observed_ = t;
  last_bin_ = clock_.on_frame(t);
  binned_ = std::max(t, binned_.value_or(t));  // the last event is older than the frame
}

std::optional<Eigen::Vector2d> EventScores::place(const Eigen::Vector3d& ray_cam,
                                                  const TurnHistory& turn) const noexcept {
  const std::optional<Timestamp> anchor = map_.reference();
  if (!anchor) return std::nullopt;
  const std::optional<Eigen::Quaterniond> R_anchor_now = turn.rotation(*anchor, observed_);
  if (!R_anchor_now) return std::nullopt;
  const Eigen::Vector3d ray = *R_anchor_now * ray_cam;
  if (!(ray.z() > 0.0)) return std::nullopt;
  return Eigen::Vector2d(grid_.fx_px * ray.x() / ray.z() + grid_.cx_px,
                         grid_.fy_px * ray.y() / ray.z() + grid_.cy_px);
}

std::optional<PixelScore> EventScores::read(const Eigen::Vector3d& ray_cam, const TurnHistory& turn,
                                            ScorePooling pooling, ScoreForm form) const noexcept {
  const std::optional<Eigen::Vector2d> px = place(ray_cam, turn);
  return px ? map_.read(px->x(), px->y(), last_bin_, pooling, form) : std::nullopt;
}

}  // namespace pled
