#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/active_surface.hpp"
#include "pled_vins/events/brightness_surface.hpp"
#include "pled_vins/events/config.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/time_surface.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// The memory of EventPictures, whatever the sensor's size. `drawing` and the pictures of a kind
/// that nobody looks at may be empty.
struct EventPictureBuffers {
  std::span<SurfacePixel> pixels;              ///< one per pixel
  std::span<BrightnessPixel> brightness;       ///< one per pixel
  std::span<float> drawing;                    ///< TimeSurface::floats_needed
  std::span<std::uint8_t> brightness_picture;  ///< one per pixel
  std::span<std::uint8_t> surface_picture;     ///< one per pixel
};

/// Which kinds of picture somebody looks at.
struct EventPictureKinds {
  bool brightness = false;
  bool time_surface = false;

  void add(EventPicture kind) noexcept {
    (kind == EventPicture::kBrightness ? brightness : time_surface) = true;
  }
};

/// The events of each pixel, drawn at each observation as whoever looks at them wants it.
class EventPictures {
 public:
  /// @param camera  of the events, lens included; @param warp  to rectified(camera). Both outlive
  ///        this object, as do the buffers
  EventPictures(const EventConfig& config, const Camera& camera, const EventWarp& warp,
                const EventPictureKinds& kinds, const EventPictureBuffers& buffers) noexcept;

  /// At most so many events at a time.
  static constexpr std::size_t kRun = 1024;

  /// Events in time order, up to the next observation.
  /// @returns what the surface thinks of each; valid until the next call
  std::span<const EventVerdict> on_events(std::span<const Event> events) noexcept;

  /// How long before an observation its events need slices that carry them to it; nothing for a
  /// picture that needs none.
  [[nodiscard]] Duration reach() const noexcept;

  /// Draws one of the kinds given: brightness at `t`, the time surface at slices.t_ref, which may
  /// be earlier when the gyro ends earlier. Both on the event camera's clock.
  /// @param slices  turning over reach(), to the observation
  void draw(EventPicture kind, const TurnSlices& slices, Timestamp t) noexcept;
  /// As last drawn: brightness in sensor pixels, the time surface rectified.
  [[nodiscard]] ImageView<const std::uint8_t> picture(EventPicture kind) const noexcept {
    return view(kind);
  }

  void reset() noexcept;

  [[nodiscard]] const ActiveSurface& surface() const noexcept { return surface_; }
  [[nodiscard]] SurfaceCounts counts() const noexcept { return surface_.counts(); }

 private:
  [[nodiscard]] ImageView<std::uint8_t> view(EventPicture kind) const noexcept;
  void forget_before_restart(std::size_t run) noexcept;

  const EventWarp& warp_;
  int width_px_;
  int height_px_;
  EventPictureKinds kinds_;
  EventPictureBuffers buffers_;
  ActiveSurface surface_;
  BrightnessSurface brightness_;
  TimeSurface drawing_;
  std::array<EventVerdict, kRun> verdicts_{};
};

/// The camera that a kind of picture is seen by: time surfaces are drawn without the lens, because
/// carrying events takes it away.
[[nodiscard]] Camera picture_camera(EventPicture kind, const Camera& camera) noexcept;

}  // namespace pled
