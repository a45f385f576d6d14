#include "pled_vins/pipeline/line_cues.hpp"

#include <algorithm>
#include <optional>

#include "pled_vins/reliability/line_band.hpp"

namespace pled {
namespace {

/// An end so near to the picture's border may be where the picture stops, not the line.
constexpr double kBorder_px = 4.0;

bool has_real_ends(const LineMeasurement& line, const CameraCalibration& camera) noexcept {
  return std::all_of(line.raw_px.begin(), line.raw_px.end(), [&](const auto& px) {
    return px[0] >= kBorder_px && px[0] <= camera.width_px - 1 - kBorder_px &&
           px[1] >= kBorder_px && px[1] <= camera.height_px - 1 - kBorder_px;
  });
}

}  // namespace

/// Where bearings of any camera fall in the map: those seen now, and those of the last frame with
/// the rotation since taken out. Turned exactly, moved by the baseline where the depth is known.
class LineCues::MapView {
 public:
  MapView(const EventStage& events, const RigCalibration& rig,
          const std::optional<Eigen::Quaterniond>& R_last_now_body) noexcept
      : events_(events), rig_(rig), knows_turn_(R_last_now_body.has_value()) {
    const Pose T_event_body = rig.cameras[rig.event_camera].T_body_cam.inverse();
    for (std::size_t i = 0; i < rig.num_cameras; ++i) {
      const Pose& T_body_cam = rig.cameras[i].T_body_cam;
      T_event_cam_[i] = T_event_body * T_body_cam;
      if (knows_turn_)
        R_now_last_[i] = T_body_cam.q.conjugate() * R_last_now_body->conjugate() * T_body_cam.q;
    }
  }

  [[nodiscard]] std::optional<Eigen::Vector2d> now(std::uint8_t camera,
                                                   const std::array<double, 2>& xy,
                                                   double inverse_depth_pm) const noexcept {
    return place(camera, Eigen::Vector3d(xy[0], xy[1], 1.0), inverse_depth_pm);
  }
  [[nodiscard]] std::optional<Eigen::Vector2d> last(std::uint8_t camera, const Eigen::Vector2d& xy,
                                                    double inverse_depth_pm) const noexcept {
    if (!knows_turn_) return std::nullopt;
    return place(camera, R_now_last_[camera] * xy.homogeneous(), inverse_depth_pm);
  }
  [[nodiscard]] const EventStage& events() const noexcept { return events_; }
  [[nodiscard]] const RigCalibration& rig() const noexcept { return rig_; }

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> place(std::uint8_t camera,
                                                     const Eigen::Vector3d& ray,
                                                     double inverse_depth_pm) const noexcept {
    const Pose& T = T_event_cam_[camera];
    return events_.map_place(T.q * ray + inverse_depth_pm * T.p);
  }

  const EventStage& events_;
  const RigCalibration& rig_;
  bool knows_turn_;
  std::array<Pose, limits::kMaxCameras> T_event_cam_;
  std::array<Eigen::Quaterniond, limits::kMaxCameras> R_now_last_;
};

LineCues::LineCues(const MotionCueConfig& config, const RigCalibration& rig) noexcept
    : rig_(rig), motion_(config, rig) {}

void LineCues::reset() noexcept {
  motion_.reset();
  size_ = 0;
}

void LineCues::judge(const FrameMeasurement& frame, std::span<const Pose> T_world_body, bool metric,
                     std::span<const MotionEvidence> points) noexcept {
  size_ = frame.lines.size();
  motion_.judge(frame, T_world_body, metric, points, evidence_);
  for (std::size_t i = 0; i < size_; ++i) {
    weights_[i] = {};
    weights_[i].motion = evidence_[i].w_static;
    alphas_[i] = {};
  }
}

void LineCues::read_map(const FrameMeasurement& frame, const MotionCue& points_motion,
                        std::span<const MotionEvidence> points,
                        const std::optional<Eigen::Quaterniond>& R_last_now_body,
                        const EventStage& events) noexcept {
  const MapView view(events, rig_, R_last_now_body);
  std::array<PointMotion, limits::kMaxPoints> moved;
  std::size_t n = 0;
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    const PointMeasurement& p = frame.points[i];
    const double rho = points[i].depth_known ? points[i].inverse_depth_pm : 0.0;
    const std::optional<Eigen::Vector2d> before = points_motion.bearing(p.id, 1, i);
    if (!before) continue;
    const std::optional<Eigen::Vector2d> then = view.last(p.camera, *before, rho);
    const std::optional<Eigen::Vector2d> now = view.now(p.camera, p.bearing_xy, rho);
    if (then && now) moved[n++] = {*now, *now - *then};
  }
  for (std::size_t i = 0; i < frame.lines.size(); ++i)
    read_line(frame.lines[i], i, view, std::span(moved).first(n));
}

void LineCues::read_line(const LineMeasurement& line, std::size_t index, const MapView& view,
                         std::span<const PointMotion> points) noexcept {
  const LineMotionEvidence& e = evidence_[index];
  const auto depth = [&](std::size_t k) { return e.depth_known ? e.inverse_depth_pm[k] : 0.0; };
  const auto start = view.now(line.camera, line.bearing_xy[0], depth(0));
  const auto end = view.now(line.camera, line.bearing_xy[1], depth(1));
  if (!start || !end) return;
  const auto paper = view.events().line_band(*start, *end, ScoreForm::kPaper);
  const auto clean = view.events().line_band(*start, *end, ScoreForm::kClean);
  if (paper && paper->with_events > 0) weights_[index].paper = temporal_reliability(*paper);
  if (clean) weights_[index].count = clean->count_reliability;

  const auto before = motion_.ends(line.id, 1, index);
  if (!before) return;
  const auto start_then = view.last(line.camera, (*before)[0], depth(0));
  const auto end_then = view.last(line.camera, (*before)[1], depth(1));
  if (!start_then || !end_then) return;
  const Eigen::Vector2d motion =
      line_motion({*start_then, *end_then}, {*start, *end},
                  has_real_ends(line, view.rig().cameras[line.camera]), points);
  if (paper)
    alphas_[index].paper = line_alpha(motion, *end - *start, paper->gradient, ScoreForm::kPaper);
  if (clean)
    alphas_[index].clean = line_alpha(motion, *end - *start, clean->gradient, ScoreForm::kClean);
}

}  // namespace pled
