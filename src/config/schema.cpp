#include "pled_vins/config/schema.hpp"

#include <array>

#include "pled_vins/core/limits.hpp"

namespace pled {
namespace {

constexpr double kMaxPoints = static_cast<double>(limits::kMaxPoints);

/// `field` of a row: the address of one member.
#define PLED_FIELD(member) [](AppConfig& c) -> ConfigField { return &c.member; }

constexpr std::array kSchema{
    ConfigKey{"camchain", "", 0, 0,
              "Kalibr camchain.yaml to use when the recording has none; empty: none",
              PLED_FIELD(calibration.camchain)},
    ConfigKey{"imu", "", 0, 0, "Kalibr imu.yaml to use when the recording has none; empty: none",
              PLED_FIELD(calibration.imu)},

    ConfigKey{"sensors.event_camera", "", 0, 0, "camera of camchain.yaml that gives the events",
              PLED_FIELD(sensors.event_camera)},
    ConfigKey{"sensors.frame_camera", "", 0, 0, "camera of camchain.yaml that gives the frames",
              PLED_FIELD(sensors.frame_camera)},

    ConfigKey{"frontend.max_points", "", 20, kMaxPoints, "points tracked at once",
              PLED_FIELD(frontend.max_points)},
    ConfigKey{"frontend.min_distance_px", "px", 3, 100,
              "least distance between two points in a 240 px wide image",
              PLED_FIELD(frontend.min_distance_px)},
    ConfigKey{"frontend.corner_quality", "", 1e-4, 0.5,
              "smallest Shi-Tomasi score as a share of the best",
              PLED_FIELD(frontend.corner_quality)},
    ConfigKey{"frontend.pyramid_levels", "", 1, limits::kMaxPyramidLevels,
              "image sizes that a point is tracked through", PLED_FIELD(frontend.pyramid_levels)},
    ConfigKey{"frontend.patch_radius_px", "px", 3, 10, "r of the (2r+1)^2 patch that is tracked",
              PLED_FIELD(frontend.patch_radius_px)},
    ConfigKey{"frontend.max_iterations", "", 3, 50, "tracking steps on each image size",
              PLED_FIELD(frontend.max_iterations)},
    ConfigKey{"frontend.forward_backward_px", "px", 0.1, 5,
              "largest distance from the start after tracking there and back",
              PLED_FIELD(frontend.forward_backward_px)},
    ConfigKey{"frontend.ransac_px", "px", 0.2, 10,
              "largest epipolar distance of a point that moves with the scene",
              PLED_FIELD(frontend.ransac_px)},

    ConfigKey{"backend.point_sigma_px", "px", 0.05, 10,
              "least noise of a tracked point, one axis; more is measured while tracking",
              PLED_FIELD(backend.point_sigma_px)},
    ConfigKey{"backend.start_sigma_px", "px", 0.05, 10,
              "noise of a tracked point, one axis, until the estimator has started",
              PLED_FIELD(backend.start_sigma_px)},
    ConfigKey{"backend.robust_scale", "sigma", 0.5, 100,
              "Cauchy scale: residuals beyond it count less", PLED_FIELD(backend.robust_scale)},
    ConfigKey{"backend.max_iterations", "", 1, 50, "solver steps for each frame",
              PLED_FIELD(backend.max_iterations)},
    ConfigKey{"backend.settled_iterations", "", 1, 50,
              "the same once it has moved for 2 s since its start, at most max_iterations",
              PLED_FIELD(backend.settled_iterations)},
    ConfigKey{"backend.keyframe_parallax_px", "px", 1, 100,
              "parallax that makes a keyframe, rotation removed, at f = 200 px",
              PLED_FIELD(backend.keyframe_parallax_px)},
    ConfigKey{"backend.min_observations", "", 2, 11, "frames that saw a point before it takes part",
              PLED_FIELD(backend.min_observations)},
    ConfigKey{"backend.imu_noise_scale", "", 0.1, 1000, "multiplies the calibrated noise densities",
              PLED_FIELD(backend.imu_noise_scale)},
    ConfigKey{"backend.estimate_time_shift", "", 0, 0,
              "refine the time offset between camera and IMU while running",
              PLED_FIELD(backend.estimate_time_shift)},
    ConfigKey{"backend.find_time_shift", "", 0, 0,
              "find a gross time offset (0.012 to 0.1 s) when no start succeeds for 2.5 s",
              PLED_FIELD(backend.find_time_shift)},
    ConfigKey{"backend.estimate_extrinsic", "", 0, 0,
              "refine the camera's place on the body while running",
              PLED_FIELD(backend.estimate_extrinsic)},
    ConfigKey{"backend.time_shift_sigma_s", "s", 1e-5, 0.1, "trust in the calibrated time offset",
              PLED_FIELD(backend.time_shift_sigma_s)},
    ConfigKey{"backend.extrinsic_sigma_m", "m", 1e-4, 1,
              "trust in the camera's calibrated position", PLED_FIELD(backend.extrinsic_sigma_m)},
    ConfigKey{"backend.extrinsic_sigma_rad", "rad", 1e-4, 1,
              "trust in the camera's calibrated rotation", PLED_FIELD(backend.extrinsic_sigma_rad)},
    ConfigKey{"backend.gyro_bias_sigma_radps", "rad/s", 1e-4, 1, "gyro bias to expect at the start",
              PLED_FIELD(backend.gyro_bias_sigma_radps)},
    ConfigKey{"backend.accel_bias_sigma_mps2", "m/s^2", 1e-3, 5,
              "accelerometer bias to expect at the start",
              PLED_FIELD(backend.accel_bias_sigma_mps2)},
    ConfigKey{"backend.gravity_mps2", "m/s^2", 9.7, 9.9, "magnitude of gravity",
              PLED_FIELD(backend.gravity_mps2)},
    ConfigKey{"backend.init_min_span_s", "s", 0.2, 5, "shortest motion to start from",
              PLED_FIELD(backend.init_min_span_s)},
    ConfigKey{"backend.init_max_span_s", "s", 0.3, 5,
              "longest motion to look back at, at least init_min_span_s",
              PLED_FIELD(backend.init_max_span_s)},
    ConfigKey{"backend.init_max_scale_sigma", "", 0.005, 1,
              "largest relative uncertainty of scale to start with",
              PLED_FIELD(backend.init_max_scale_sigma)},
};

#undef PLED_FIELD

}  // namespace

std::span<const ConfigKey> config_schema() noexcept { return kSchema; }

}  // namespace pled
