#pragma once

#include <array>
#include <random>
#include <span>

#include <Eigen/Core>

#include "pled_vins/backend/start.hpp"
#include "src/backend/start/imu_path.hpp"
#include "src/backend/start/tracks.hpp"

namespace pled::start {

/// The gyro bias that makes the tracks of frame pairs coplanar with one translation per pair
/// (Kneip and Lynen, ICCV 2013, with all pairs sharing one bias), by RANSAC over tracks and then
/// robustly from all. Holds for motion without translation too: then any direction will do.
class GyroBiasSearch {
 public:
  /// Returns what is to be added to the gyro bias that `path` was integrated with, rad/s; about
  /// `prior_sigma_radps` is expected.
  [[nodiscard]] Eigen::Vector3d find(const Tracks& tracks, const ImuPath& path,
                                     const RigCalibration& rig, const BackendConfig& config,
                                     double prior_sigma_radps) noexcept;

 private:
  static constexpr std::size_t kPairs = 6;

  /// Two frames far enough apart to see a parallax.
  struct FramePair {
    std::size_t first = 0;
    std::size_t second = 0;
    Eigen::Matrix3d W_first, W_second;  ///< turn of the ray, frame 0, by the bias
  };
  /// A track in a pair: unit rays, frame 0.
  struct Match {
    Eigen::Vector3d u, v;
    bool seen = false;
  };
  using Directions = std::array<Eigen::Vector3d, kPairs>;

  void choose_pairs(const ImuPath& path) noexcept;
  void match(const Tracks& tracks, const ImuPath& path, const RigCalibration& rig) noexcept;
  [[nodiscard]] const Match& at(std::size_t pair, std::size_t track) const noexcept {
    return matches_[pair * kMaxTracks + track];
  }
  /// Rays turned by a bias.
  void turned(std::size_t pair, std::size_t track, const Eigen::Vector3d& bg, Eigen::Vector3d& u,
              Eigen::Vector3d& v) const noexcept;
  /// Directions at `bg` and one Gauss-Newton step of the bias, from chosen tracks with weights.
  void step(std::span<const std::size_t> chosen, double sigma, double prior_sigma,
            Directions& directions, Eigen::Vector3d& bg) const noexcept;
  /// Mean squared coplanarity error of each track into error_; truncated sum over tracks.
  [[nodiscard]] double score(const Eigen::Vector3d& bg, const Directions& directions,
                             double gate) noexcept;

  std::array<FramePair, kPairs> pairs_{};
  std::size_t num_pairs_ = 0;
  std::array<Match, kPairs * kMaxTracks> matches_{};
  std::array<double, kMaxTracks> weight_{};
  std::array<double, kMaxTracks> error_{};
  std::array<std::size_t, kMaxTracks> usable_{};
  std::size_t num_usable_ = 0;
};

/// Median image motion, pixels, between the first and last sight of each long track, once the
/// rotation of `path` is removed; `rotate` false: the plain image motion.
[[nodiscard]] double median_motion_px(const Tracks& tracks, const ImuPath& path,
                                      const RigCalibration& rig, bool rotate) noexcept;

}  // namespace pled::start
