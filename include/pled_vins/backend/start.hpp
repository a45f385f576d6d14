#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "pled_vins/backend/config.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/imu/preintegration.hpp"

namespace pled {

/// Why the estimator has not started yet; each has one sentence for the user.
enum class StartRefusal : std::uint8_t {
  kNone,
  kNoImu,              ///< no inertial data over the frames
  kImuGap,             ///< a hole in the inertial data among the frames
  kTooFewFrames,       ///< not enough frames yet
  kTooShort,           ///< the frames span too little time
  kTooFewTracks,       ///< too few points seen through the frames
  kTooLittleParallax,  ///< the camera only turned, or stood, but not still enough for a static
                       ///< start
  kWeakScale,          ///< motion does not tell the scale yet
  kGravity,            ///< gravity comes out with a wrong magnitude
  kOutliers,           ///< too few points agree on one motion
  kBias,               ///< biases come out implausibly large
  kNoSolution,         ///< the equations are degenerate
  kUnconfirmed,        ///< a motion is found, but not yet found again from later frames
};

/// What is missing and what to do, e.g. "the points hardly move: move the camera sideways".
[[nodiscard]] std::string_view to_string(StartRefusal refusal) noexcept;

/// Frames waiting for a start, oldest first, about evenly spread over at most
/// init_max_span_s.
using StartFrames = FixedVector<FrameMeasurement, limits::kInitFrames>;

/// Up to one state per frame, oldest first; used like a FixedVector (which takes no Eigen types).
class StartStates {
 public:
  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return limits::kInitFrames; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  /// False when full; unchanged then.
  [[nodiscard]] bool push_back(const NavState& state) noexcept {
    if (size_ == items_.size()) return false;
    items_[size_++] = state;
    return true;
  }
  void clear() noexcept { size_ = 0; }
  [[nodiscard]] NavState& operator[](std::size_t i) noexcept {
    PLED_CHECK(i < size_);
    return items_[i];
  }
  [[nodiscard]] const NavState& operator[](std::size_t i) const noexcept {
    PLED_CHECK(i < size_);
    return items_[i];
  }
  [[nodiscard]] const NavState& front() const noexcept { return (*this)[0]; }
  [[nodiscard]] const NavState& back() const noexcept { return (*this)[size_ - 1]; }
  [[nodiscard]] NavState* begin() noexcept { return items_.data(); }
  [[nodiscard]] NavState* end() noexcept { return items_.data() + size_; }
  [[nodiscard]] const NavState* begin() const noexcept { return items_.data(); }
  [[nodiscard]] const NavState* end() const noexcept { return items_.data() + size_; }

 private:
  std::array<NavState, limits::kInitFrames> items_{};
  std::size_t size_ = 0;
};

/// What is known before a start: biases from an earlier life of the estimator, or zero.
struct StartBelief {
  Eigen::Vector3d bg = Eigen::Vector3d::Zero();
  Eigen::Vector3d ba = Eigen::Vector3d::Zero();
  double bg_sigma_radps = 0.05;
  double ba_sigma_mps2 = 0.1;
};

/// A first guess of every state, or the reason there is none.
struct StartGuess {
  StartRefusal refusal = StartRefusal::kTooFewFrames;
  bool stationary = false;    ///< found to stand still: v = 0, no depths
  double detail = 0.0;        ///< the figure that was judged, for the message
  double scale_sigma = 0.0;   ///< relative sigma of the travelled distance; 0 when stationary
  double inlier_share = 0.0;  ///< of the points seen long enough, those that agree with the motion
  double error_sigmas = 0.0;  ///< rms of their errors, in sigmas of one axis
  StartStates states;         ///< one per frame; world z up, first at the origin, yaw 0
  FixedVector<FeatureId, limits::kMaxPoints> inliers;  ///< points that agree with the motion
};

/// Finds the first states from frames and IMU alone: still, or in motion. States are given only
/// with StartRefusal::kNone. Deterministic, no allocation; its workspace of about 200 KB lies on
/// the stack. Cost: some ten milliseconds in motion, well under one when refused early.
[[nodiscard]] StartGuess guess_start(const StartFrames& frames, const ImuHistory& imu,
                                     const RigCalibration& rig, const BackendConfig& config,
                                     const StartBelief& belief) noexcept;
/// The same with nothing known but the configured spread of the biases.
[[nodiscard]] StartGuess guess_start(const StartFrames& frames, const ImuHistory& imu,
                                     const RigCalibration& rig,
                                     const BackendConfig& config) noexcept;
/// Biases about zero, as widely spread as configured.
[[nodiscard]] StartBelief no_belief(const BackendConfig& config) noexcept;

}  // namespace pled
