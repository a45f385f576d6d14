#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/timestamp.hpp"

namespace pled {

enum class Polarity : std::uint8_t { kOff = 0, kOn = 1 };

/// One brightness change, e_i = {x, y, t, p}. Paper, section II-A.
struct Event {
  Timestamp t;
  std::uint16_t x_px = 0;
  std::uint16_t y_px = 0;
  Polarity polarity = Polarity::kOff;
};
static_assert(std::is_trivially_copyable_v<Event> && sizeof(Event) == 16);

/// One raw inertial reading in the body (IMU) frame; biases not removed.
struct ImuSample {
  Timestamp t;
  std::array<double, 3> gyro_radps{};  ///< angular rate
  std::array<double, 3> accel_mps2{};  ///< specific force: +9.81 on the up axis at rest
};
static_assert(std::is_trivially_copyable_v<ImuSample>);

/// One 8-bit grey image. The pixels belong to the source and stay valid until
/// it is told to release the frame.
struct FrameView {
  Timestamp t;                ///< mid-exposure on the camera's clock, rounded to 1 us
  std::int64_t stamp_ns = 0;  ///< the stamp as the recording or device gave it
  ImageView<const std::uint8_t> image;
};

/// Where a feature was seen first. Ids are unique over a run and never reused.
using FeatureId = std::uint32_t;

enum class FeatureKind : std::uint8_t { kImagePoint, kEventPoint, kLine };
inline constexpr std::size_t kFeatureKinds = 3;

/// One point in one frame.
struct PointMeasurement {
  FeatureId id = 0;
  FeatureKind kind = FeatureKind::kImagePoint;
  std::uint8_t camera = 0;             ///< index into the rig's cameras
  bool inlier = true;                  ///< agrees with the camera's motion (two-point RANSAC)
  bool for_solver = true;              ///< false: followed, but not needed for the pose
  std::uint32_t track_length = 1;      ///< frames in which it has been seen, this one included
  std::array<double, 2> raw_px{};      ///< distorted pixel, as the sensor gave it
  std::array<double, 2> bearing_xy{};  ///< undistorted, z = 1, camera frame
  std::array<double, 2> bearing_rate_xyps{};  ///< its rate over the last frame interval, 1/s
  /// What time tells of it before the bundle adjustment: 1 at rest, 0 moving; NaN: nothing.
  double w_temporal = std::numeric_limits<double>::quiet_NaN();
};

/// Ids of lines begin here: of those seen in frames, and of those seen in events. Image points lie
/// below the first, event points between the two.
inline constexpr FeatureId kFirstImageLineId = 0x4000'0001U;
inline constexpr FeatureId kFirstEventLineId = 0xC000'0001U;

/// One line in one picture. Its ends are where it was seen to end: they slide along it from picture
/// to picture and are no points. Going from the first to the second the bright side is on the left
/// of a screen (y down), so the two do not swap.
struct LineMeasurement {
  FeatureId id = 0;
  std::uint8_t camera = 0;         ///< index into the rig's cameras
  bool inlier = true;              ///< goes on as it has moved so far (LineTracker)
  std::uint32_t track_length = 1;  ///< pictures in which it has been seen, this one included
  double length_px = 0.0;          ///< in pixels without lens distortion
  std::array<std::array<double, 2>, 2> raw_px{};      ///< ends as the sensor gave them
  std::array<std::array<double, 2>, 2> bearing_xy{};  ///< ends undistorted, z = 1, camera frame
  /// Rate of each end across the line over the last interval, 1/s; along it nothing is known.
  std::array<std::array<double, 2>, 2> bearing_rate_xyps{};
  double w_temporal = std::numeric_limits<double>::quiet_NaN();  ///< as of a point
  /// Share of w_temporal in the fused weight by the paper, eq. (15); NaN: unknown.
  double alpha_line = std::numeric_limits<double>::quiet_NaN();
};

/// What the front end saw in one frame.
struct FrameMeasurement {
  Timestamp t;                ///< mid-exposure on the estimator (IMU) clock: stamp + time shift
  std::int64_t stamp_ns = 0;  ///< as in FrameView
  FixedVector<PointMeasurement, limits::kMaxPoints> points;
  FixedVector<LineMeasurement, limits::kMaxLines> lines;
  double median_flow_px = 0.0;      ///< median image motion since the last frame
  double median_parallax_px = 0.0;  ///< the same after removing the gyro's rotation
  std::uint32_t lost = 0;           ///< tracks that ended in this frame
};
static_assert(std::is_trivially_copyable_v<FrameMeasurement>);

inline constexpr double kNoEvidence = std::numeric_limits<double>::quiet_NaN();

/// How far one tracked feature was believed right after a frame's solve.
/// A cue without evidence is kNoEvidence (NaN), never 1.
struct FeatureWeight {
  FeatureId id = 0;
  double w_temporal = kNoEvidence;
  double w_geometric = kNoEvidence;
  double w = kNoEvidence;          ///< the weight that counts; 0 when gated out
  std::uint16_t observations = 0;  ///< frames of the window in which it is seen
  bool used = false;               ///< took part in the solve
};

enum class EstimatorStatus : std::uint8_t { kWaiting, kInitialising, kTracking, kDegraded, kLost };

/// The newest state, as known right after a frame.
struct PoseEstimate {
  Timestamp t;
  std::int64_t stamp_ns = 0;
  std::array<double, 3> p_world_body_m{};
  std::array<double, 4> q_world_body_xyzw{0, 0, 0, 1};
  std::array<double, 3> v_world_body_mps{};
  std::array<double, 3> gyro_bias_radps{};
  std::array<double, 3> accel_bias_mps2{};
  EstimatorStatus status = EstimatorStatus::kWaiting;
  std::uint32_t reset_counter = 0;
};
static_assert(std::is_trivially_copyable_v<PoseEstimate>);

}  // namespace pled
