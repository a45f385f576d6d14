#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "pled_vins/backend/start.hpp"

namespace pled::start {

inline constexpr std::size_t kMaxTracks = 120;
inline constexpr std::size_t kMaxFrames = limits::kInitFrames;

/// One sight of a point: single precision is a ten-thousandth of a pixel here.
struct Sight {
  std::uint32_t frame = 0;
  std::array<float, 2> xy{};  ///< undistorted, z = 1, camera frame

  [[nodiscard]] Eigen::Vector3d ray() const noexcept {
    return {static_cast<double>(xy[0]), static_cast<double>(xy[1]), 1.0};
  }
};

/// The frames' points turned round: per point, where it was seen. The longest tracks are kept.
class Tracks {
 public:
  /// Takes every point seen in at least `min_sights` frames, the most often seen first (older ids
  /// first among equals).
  void build(const StartFrames& frames, std::size_t min_sights) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] FeatureId id(std::size_t i) const noexcept { return ids_[i].id; }
  [[nodiscard]] std::size_t camera(std::size_t i) const noexcept { return cameras_[i]; }
  /// In order of frames.
  [[nodiscard]] std::span<const Sight> sights(std::size_t i) const noexcept {
    return {sights_.data() + i * kMaxFrames, ids_[i].count};
  }

 private:
  struct Count {
    FeatureId id = 0;
    std::uint32_t count = 0;
  };
  [[nodiscard]] std::size_t count_ids(const StartFrames& frames) noexcept;

  std::array<Count, kMaxFrames * limits::kMaxPoints> ids_{};
  std::array<std::uint8_t, kMaxTracks> cameras_{};
  std::array<Sight, kMaxTracks * kMaxFrames> sights_{};
  std::size_t size_ = 0;
};

}  // namespace pled::start
