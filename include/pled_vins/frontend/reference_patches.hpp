#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/frontend/patch_aligner.hpp"

namespace pled {

/// The surroundings of each track as they were when it was first seen. Following a track from frame
/// to frame adds up small errors; aligning it with its first view takes them out again.
class ReferencePatches {
 public:
  /// Pixels kept on each side of the track: enough for the largest patch at 1.4 times its size.
  static constexpr int kReach = 16;
  static constexpr int kSide = 2 * kReach + 1;
  static constexpr std::size_t kSlotValues = std::size_t{kSide} * std::size_t{kSide};
  static constexpr std::size_t kValues = limits::kMaxPoints * kSlotValues;
  using Slot = std::uint8_t;

  /// `memory` holds kValues and outlives this object.
  explicit ReferencePatches(std::span<std::int16_t> memory) noexcept;

  /// A free slot; nullopt when all are taken.
  [[nodiscard]] std::optional<Slot> acquire() noexcept;
  void release(Slot slot) noexcept;
  void release_all() noexcept { taken_.reset(); }

  /// Copies the surroundings of `centre_px` (inside `level`, a pyramid level 0).
  void store(Slot slot, ImageView<const std::int16_t> level,
             const Eigen::Vector2d& centre_px) noexcept;

  /// The stored pixels, and where in them the track lies.
  [[nodiscard]] PatchSource source(Slot slot) const noexcept;
  [[nodiscard]] Eigen::Vector2d centre_px(Slot slot) const noexcept;

 private:
  struct Entry {
    std::array<double, 2> centre_px{};
    int x_min = 0, y_min = 0, x_max = 0, y_max = 0;  ///< what was inside the image
  };
  std::span<std::int16_t> memory_;
  std::array<Entry, limits::kMaxPoints> entries_{};
  std::bitset<limits::kMaxPoints> taken_;
};

}  // namespace pled
