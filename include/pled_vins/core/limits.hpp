#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// Every capacity of the estimator. Nothing outside this header decides how
/// much memory is used; `pled-vins budget` prints what it adds up to.
namespace pled::limits {

/// A class of sensor sizes. Storage is laid out for the class; a recording or a
/// device uses the smallest class that holds its pixels.
struct SensorClass {
  std::string_view name;
  int width_px;
  int height_px;
};

inline constexpr SensorClass kDavis240{"davis240", 240, 180};
inline constexpr SensorClass kDavis346{"davis346", 346, 260};
inline constexpr SensorClass kVga{"vga", 640, 480};
inline constexpr SensorClass kWvga{"wvga", 752, 480};
inline constexpr SensorClass kHd{"hd", 1280, 720};

/// Smallest first, so the first that fits is the one to use.
inline constexpr std::array kSensorClasses{kDavis240, kDavis346, kVga, kWvga, kHd};

inline constexpr int kMaxPyramidLevels = 4;

/// Points followed at once, frame and event corners together.
inline constexpr std::size_t kMaxPoints = 150;
/// Lines followed at once.
inline constexpr std::size_t kMaxLines = 64;
/// Pieces of straight edges in one picture that are looked at, the longest ones: lines break into
/// a few each, and of a time surface every edge has two sides.
inline constexpr std::size_t kMaxSegments = 256;

/// B, the time bins of the entropy-recency map. Paper: 8.
inline constexpr std::size_t kTimeBins = 8;
/// Pixels that the map's grid has on each side beyond the sensor, for events turned out of it.
inline constexpr int kMapMargin_px = 16;

/// Earlier frames that the motion cue looks back on: 0.3 s at 20 Hz.
inline constexpr std::size_t kCueFrames = 6;

/// Sliding window: ten keyframes and the newest frame.
inline constexpr std::size_t kWindowStates = 11;

/// Inertial samples between two states. 2048 at 1 kHz is 2 s.
inline constexpr std::size_t kMaxImuPerInterval = 2048;
/// Inertial history shared by the stages: 4096 at 1 kHz is 4 s.
inline constexpr std::size_t kImuHistory = 4096;

/// Frames kept while the estimator has not started, decimated to this many.
inline constexpr std::size_t kInitFrames = 24;

inline constexpr std::size_t kImuRing = 2048;
inline constexpr std::size_t kFrameSlots = 4;
inline constexpr std::size_t kPoseRing = 64;

/// Bytes of one chunk of raw sensor data, and how many are held.
inline constexpr std::size_t kChunkBytes = 16 * 1024;
inline constexpr std::size_t kChunkSlots = 8;

/// Events decoded in one call: a chunk of EVT3 yields at most 12 events for each
/// 2-byte word.
inline constexpr std::size_t kMaxEventsPerChunk = kChunkBytes / 2 * 12;

/// Accepted events kept for the corner scan: 40 ms at 0.2 million a second.
inline constexpr std::size_t kEventRing = 8192;
/// Knots of the camera's orientation, 1.024 ms apart: 1 s.
inline constexpr std::size_t kTurnKnots = 1024;
/// Slices of constant rotation: 131 ms of 64 us each in the fastest turns.
inline constexpr std::size_t kMaxTurnSlices = 2048;
/// Cells of the grid that keeps event corners apart.
inline constexpr std::size_t kMaxEventCells = 32768;

inline constexpr std::size_t kMaxCameras = 2;

}  // namespace pled::limits
