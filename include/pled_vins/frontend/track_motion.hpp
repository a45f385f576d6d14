#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/frontend/motion_check.hpp"
#include "pled_vins/frontend/point_track.hpp"

namespace pled {

/// Asks of each track whether it moves with the scene. Long tracks are judged against a frame about
/// 0.2 s back, where parallax shows; younger ones against the previous frame.
class TrackMotion {
 public:
  TrackMotion(double focal_px, double gate_px) noexcept : check_(focal_px, gate_px) {}

  void reset() noexcept;

  /// Compares with no frame so far: the rotations between them were taken at wrong times.
  void forget_past() noexcept { known_back_ = 0; }

  /// Once per frame, before judge(). nullopt: rotation unknown, the past cannot be compared.
  void advance(Timestamp t, const std::optional<Eigen::Quaterniond>& R_prev_cur) noexcept;

  /// Sets `inlier` and `strikes` of each track that has a past.
  void judge(std::span<PointTrack> tracks) noexcept;

  /// Keeps the bearings of this frame for later ones, once its new tracks are there.
  void file_bearings(std::span<PointTrack> tracks) const noexcept;

  /// True when the check has disagreed with the track for three frames, or strongly for two.
  [[nodiscard]] static bool is_struck_out(const PointTrack& track) noexcept;

 private:
  [[nodiscard]] std::size_t choose_baseline(std::span<const PointTrack> tracks) const noexcept;
  void judge_against(std::size_t back, std::span<PointTrack> tracks, std::uint32_t min_length,
                     std::uint32_t judged_below) noexcept;

  MotionCheck check_;
  std::uint64_t frame_ = 0;
  std::size_t known_back_ = 0;  ///< so many earlier frames are linked to this one by rotations
  std::array<Eigen::Quaterniond, kTrackHistory> q_first_cam_{};  ///< camera to the run's first
  std::array<Timestamp, kTrackHistory> time_{};
};

}  // namespace pled
