#include "pled_vins/frontend/track_motion.hpp"

#include <algorithm>
#include <limits>

#include "pled_vins/core/limits.hpp"

namespace pled {
namespace {

constexpr Duration kLongestBaseline = Duration::from_ms(250);
constexpr std::size_t kMinTracks = 15;
/// Three disagreements of 2 in a row, or two strong ones of 3, end a track.
constexpr int kStrike = 2;
constexpr int kStrongStrike = 3;
constexpr int kStruckOut = 6;
constexpr double kStrongPx = 6.0;
constexpr std::uint32_t kAnyLength = std::numeric_limits<std::uint32_t>::max();

}  // namespace

void TrackMotion::reset() noexcept {
  check_.reset();
  known_back_ = 0;
}

void TrackMotion::advance(Timestamp t,
                          const std::optional<Eigen::Quaterniond>& R_prev_cur) noexcept {
  const std::size_t before = frame_ % kTrackHistory;
  ++frame_;
  const std::size_t now = frame_ % kTrackHistory;
  if (R_prev_cur) {
    q_first_cam_[now] = (q_first_cam_[before] * *R_prev_cur).normalized();
    known_back_ = std::min(known_back_ + 1, kTrackHistory - 1);
  } else {
    q_first_cam_[now] = Eigen::Quaterniond::Identity();
    known_back_ = 0;
  }
  time_[now] = t;
}

void TrackMotion::judge(std::span<PointTrack> tracks) noexcept {
  for (PointTrack& track : tracks) track.inlier = true;
  if (known_back_ == 0) return;
  const std::size_t back = choose_baseline(tracks);
  const auto long_enough = static_cast<std::uint32_t>(back + 1);
  if (back > 1) {
    judge_against(back, tracks, long_enough, kAnyLength);
    judge_against(1, tracks, 2, long_enough);
  } else {
    judge_against(1, tracks, 2, kAnyLength);
  }
}

void TrackMotion::file_bearings(std::span<PointTrack> tracks) const noexcept {
  for (PointTrack& track : tracks)
    track.past_bearings[frame_ % kTrackHistory] = {track.bearing.x(), track.bearing.y()};
}

bool TrackMotion::is_struck_out(const PointTrack& track) noexcept {
  return track.strikes >= kStruckOut;
}

/// The furthest frame back that enough tracks have seen.
std::size_t TrackMotion::choose_baseline(std::span<const PointTrack> tracks) const noexcept {
  for (std::size_t back = known_back_; back > 1; --back) {
    if (time_[frame_ % kTrackHistory] - time_[(frame_ - back) % kTrackHistory] > kLongestBaseline)
      continue;
    const auto seen = static_cast<std::size_t>(std::count_if(
        tracks.begin(), tracks.end(), [&](const PointTrack& t) { return t.length > back; }));
    if (seen >= kMinTracks && 2 * seen >= tracks.size()) return back;
  }
  return 1;
}

/// All tracks of at least `min_length` frames vote; those shorter than `judged_below` get a
/// verdict.
void TrackMotion::judge_against(std::size_t back, std::span<PointTrack> tracks,
                                std::uint32_t min_length, std::uint32_t judged_below) noexcept {
  std::array<BearingPair, limits::kMaxPoints> pairs;
  std::array<MotionVerdict, limits::kMaxPoints> verdicts;
  std::array<std::size_t, limits::kMaxPoints> index;
  std::size_t n = 0;
  const std::size_t then = (frame_ - back) % kTrackHistory;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (tracks[i].length < min_length) continue;
    const std::array<double, 2>& from = tracks[i].past_bearings[then];
    pairs[n] = {from[0], from[1], tracks[i].bearing.x(), tracks[i].bearing.y()};
    index[n++] = i;
  }
  const Eigen::Quaterniond q_to_from =
      q_first_cam_[frame_ % kTrackHistory].conjugate() * q_first_cam_[then];
  (void)check_.judge(q_to_from.toRotationMatrix(), std::span(pairs).first(n),
                     std::span(verdicts).first(n));
  for (std::size_t k = 0; k < n; ++k) {
    PointTrack& track = tracks[index[k]];
    if (track.length >= judged_below) continue;
    track.inlier = verdicts[k].inlier;
    if (track.inlier) {
      track.strikes = 0;
    } else {
      track.strikes += verdicts[k].residual_px > kStrongPx ? kStrongStrike : kStrike;
    }
  }
}

}  // namespace pled
