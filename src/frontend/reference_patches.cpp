#include "pled_vins/frontend/reference_patches.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"
#include "pled_vins/frontend/pyramid.hpp"

namespace pled {

static_assert(ReferencePatches::kReach <= kPyramidPad, "store() copies from the margin");
static_assert(limits::kMaxPoints <= 256, "Slot is 8 bits");

ReferencePatches::ReferencePatches(std::span<std::int16_t> memory) noexcept : memory_(memory) {
  PLED_CHECK(memory_.size() >= kValues);
}

std::optional<ReferencePatches::Slot> ReferencePatches::acquire() noexcept {
  for (std::size_t i = 0; i < limits::kMaxPoints; ++i) {
    if (taken_[i]) continue;
    taken_.set(i);
    return static_cast<Slot>(i);
  }
  return std::nullopt;
}

void ReferencePatches::release(Slot slot) noexcept { taken_.reset(slot); }

void ReferencePatches::store(Slot slot, ImageView<const std::int16_t> level,
                             const Eigen::Vector2d& centre_px) noexcept {
  const auto x0 = static_cast<int>(std::floor(centre_px.x()));
  const auto y0 = static_cast<int>(std::floor(centre_px.y()));
  PLED_CHECK(x0 >= 0 && y0 >= 0 && x0 < level.width && y0 < level.height);
  Entry& entry = entries_[slot];
  entry.centre_px = {kReach + centre_px.x() - x0, kReach + centre_px.y() - y0};
  entry.x_min = std::max(0, kReach - x0);
  entry.y_min = std::max(0, kReach - y0);
  entry.x_max = std::min(kSide - 1, level.width - 1 - x0 + kReach);
  entry.y_max = std::min(kSide - 1, level.height - 1 - y0 + kReach);
  std::int16_t* out = memory_.data() + slot * kSlotValues;
  for (int y = y0 - kReach; y <= y0 + kReach; ++y, out += kSide)
    std::copy_n(level.row(y) + x0 - kReach, kSide, out);
}

PatchSource ReferencePatches::source(Slot slot) const noexcept {
  const Entry& e = entries_[slot];
  const ImageView<const std::int16_t> image{memory_.data() + slot * kSlotValues, kSide, kSide,
                                            kSide};
  return {image, e.x_min, e.y_min, e.x_max, e.y_max};
}

Eigen::Vector2d ReferencePatches::centre_px(Slot slot) const noexcept {
  return {entries_[slot].centre_px[0], entries_[slot].centre_px[1]};
}

}  // namespace pled
