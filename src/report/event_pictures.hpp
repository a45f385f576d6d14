#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/replay/image_codec.hpp"
#include "pled_vins/core/messages.hpp"
#include "src/report/picture.hpp"

namespace pled::report {

/// Pictures of the events in the 30 ms before each of some stamps.
class EventPictures {
 public:
  static constexpr std::int64_t kWindow_us = 30'000;
  /// Values of a pixel: nothing, darker last, brighter last.
  static constexpr std::uint8_t kNone = 0, kOff = 127, kOn = 255;

  /// Stamps in rising order; pictures no wider than `max_width_px`.
  EventPictures(std::vector<std::int64_t> stamps_us, replay::ImageSize sensor, int max_width_px);

  /// Events in the order of time.
  void add(std::span<const Event> events);

  [[nodiscard]] const Picture& picture(std::size_t moment) const { return pictures_[moment]; }
  [[nodiscard]] std::uint64_t count(std::size_t moment) const { return counts_[moment]; }

 private:
  void paint(std::size_t moment, const Event& event);

  std::vector<std::int64_t> stamps_us_;
  replay::ImageSize sensor_;
  std::vector<Picture> pictures_;
  std::vector<std::uint64_t> counts_;
  std::size_t next_ = 0;  ///< first moment that has not passed
};

}  // namespace pled::report
