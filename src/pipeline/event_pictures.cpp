#include "pled_vins/pipeline/event_pictures.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {

EventPictures::EventPictures(const EventConfig& config, const Camera& camera, const EventWarp& warp,
                             const EventPictureKinds& kinds,
                             const EventPictureBuffers& buffers) noexcept
    : warp_(warp),
      width_px_(camera.calibration().width_px),
      height_px_(camera.calibration().height_px),
      kinds_(kinds),
      buffers_(buffers),
      surface_(config, width_px_, height_px_, buffers.pixels),
      brightness_(config.brightness_decay_ms, width_px_, height_px_, buffers.brightness),
      drawing_(config.surface_decay_ms) {}

ImageView<std::uint8_t> EventPictures::view(EventPicture kind) const noexcept {
  const std::span<std::uint8_t> pixels =
      kind == EventPicture::kBrightness ? buffers_.brightness_picture : buffers_.surface_picture;
  return {pixels.data(), width_px_, height_px_, width_px_};
}

void EventPictures::reset() noexcept {
  surface_.clear();
  brightness_.clear();
}

std::span<const EventVerdict> EventPictures::on_events(std::span<const Event> events) noexcept {
  PLED_CHECK(events.size() <= kRun);
  const std::span<EventVerdict> verdicts = std::span(verdicts_).first(events.size());
  const std::uint64_t restarts = surface_.counts().restarts;
  surface_.insert(events, verdicts);
  if (surface_.counts().restarts != restarts) forget_before_restart(events.size());
  if (kinds_.brightness) brightness_.insert(events, verdicts);
  return verdicts;
}

/// The active surface has begun anew in the middle of a run of events, behind some that it dropped.
void EventPictures::forget_before_restart(std::size_t run) noexcept {
  brightness_.clear();
  const std::span<EventVerdict> told = std::span(verdicts_).first(run);
  const auto last_dropped = std::find(told.rbegin(), told.rend(), EventVerdict::kDropped);
  std::fill(told.begin(), last_dropped.base(), EventVerdict::kDropped);
}

Duration EventPictures::reach() const noexcept {
  return kinds_.time_surface ? drawing_.reach(Meeting::kBlended) : Duration{};
}

void EventPictures::draw(EventPicture kind, const TurnSlices& slices, Timestamp t) noexcept {
  if (kind == EventPicture::kTimeSurface) {
    PLED_CHECK(kinds_.time_surface);
    PLED_CHECK(drawing_.render(surface_, warp_, slices, SurfaceTone::kSigned, Meeting::kBlended,
                               buffers_.drawing, view(kind)));
  } else {
    PLED_CHECK(kinds_.brightness);
    PLED_CHECK(brightness_.render(t, view(kind)));
  }
}

Camera picture_camera(EventPicture kind, const Camera& camera) noexcept {
  return kind == EventPicture::kTimeSurface ? Camera(rectified(camera.calibration())) : camera;
}

}  // namespace pled
