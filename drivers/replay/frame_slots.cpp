#include "drivers/replay/frame_slots.hpp"

#include <cstdlib>

#include "pled_vins/core/check.hpp"

namespace pled::replay {

FrameSlots::FrameSlots(Options options)
    : options_(options),
      slot_pixels_(static_cast<std::size_t>(options.max.width_px) *
                   static_cast<std::size_t>(options.max.height_px)) {
  PLED_CHECK(options_.slots >= 1);
  for (std::size_t i = 0; i < options_.slots; ++i)
    slots_.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(slot_pixels_));
  if (options_.one_size) size_ = options_.max;
}

bool FrameSlots::takes_size(ImageSize size) noexcept {
  const bool fits =
      size.width_px <= options_.max.width_px && size.height_px <= options_.max.height_px;
  if (fits && size_ == ImageSize{}) size_ = size;
  if (fits && size == size_) return true;
  ++faults_.unreadable;
  return false;
}

bool FrameSlots::takes_stamp(std::int64_t t_us) noexcept {
  constexpr std::int64_t kFar_us = 2'000'000;  // between stamps of one clock
  const bool is_far = has_stamp_ && std::llabs(t_us - last_us_) > kFar_us;
  if (has_stamp_ && !is_far && t_us <= last_us_) {
    ++faults_.out_of_order;
    return false;
  }
  if (!is_far) last_us_ = t_us;
  has_stamp_ = true;
  return true;
}

std::span<std::uint8_t> FrameSlots::next_slot() noexcept {
  PLED_CHECK(!full());
  return {slots_[(first_held_ + held_) % slots_.size()].get(), slot_pixels_};
}

FrameView FrameSlots::push(std::int64_t t_us, ImageSize size) noexcept {
  const std::span<const std::uint8_t> pixels = next_slot();
  ++held_;
  FrameView view;
  view.t = {t_us};
  view.stamp_ns = t_us * 1000;
  view.image = {pixels.data(), size.width_px, size.height_px, size.width_px};
  return view;
}

void FrameSlots::release() noexcept {
  PLED_CHECK(held_ > 0);
  first_held_ = (first_held_ + 1) % slots_.size();
  --held_;
}

}  // namespace pled::replay
