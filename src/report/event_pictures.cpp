#include "src/report/event_pictures.hpp"

#include <algorithm>
#include <utility>

namespace pled::report {

EventPictures::EventPictures(std::vector<std::int64_t> stamps_us, replay::ImageSize sensor,
                             int max_width_px)
    : stamps_us_(std::move(stamps_us)), sensor_(sensor), counts_(stamps_us_.size()) {
  const int width = std::min(max_width_px, sensor.width_px);
  const int height = std::max(1, sensor.height_px * width / std::max(1, sensor.width_px));
  pictures_.assign(stamps_us_.size(), Picture(width, height));
}

void EventPictures::add(std::span<const Event> events) {
  for (const Event& event : events) {
    while (next_ < stamps_us_.size() && stamps_us_[next_] < event.t.us) ++next_;
    // Windows may overlap where moments are close together.
    for (std::size_t k = next_; k < stamps_us_.size(); ++k) {
      if (event.t.us <= stamps_us_[k] - kWindow_us) break;
      paint(k, event);
    }
  }
}

void EventPictures::paint(std::size_t moment, const Event& event) {
  Picture& picture = pictures_[moment];
  const int x = event.x_px * picture.width_px / sensor_.width_px;
  const int y = event.y_px * picture.height_px / sensor_.height_px;
  picture.at(y, x) = event.polarity == Polarity::kOn ? kOn : kOff;
  ++counts_[moment];
}

}  // namespace pled::report
