#include "tests/support/flown_window.hpp"

#include <random>

#include <doctest/doctest.h>

#include "pled_vins/backend/line_book.hpp"
#include "tests/support/simulated_run.hpp"

namespace pled::support {

FreeWindow::FreeWindow() {
  PointWorldOptions options;
  options.duration_s = 0.55;
  const PointWorld world(options);
  rig = world.rig();
  BackendConfig config;
  config.point_sigma_px = options.pixel_sigma;
  settings = make_factor_settings(config, rig);
  SimulatedRun run(world, config);
  NavState truth = world.truth(world.frames()[0].t);
  run.backend().start_from(truth, Vector15d::Constant(0.01));
  for (std::size_t k = 0; k < 10; ++k) REQUIRE(run.step(k).has_pose);
  window = std::make_unique<SlidingWindow>(run.backend().window());
  REQUIRE(window->size() == 10);
  window->state(0).prior.reset();
  for (Landmark& l : window->landmarks) l.weak_depth = false;
}

GaugedWindow::GaugedWindow() {
  StatePrior gauge;
  gauge.mean = window->state(0).x;
  gauge.sqrt_information = Matrix15d::Identity() * 100.0;
  window->state(0).prior = gauge;
}

void add_lines(FreeWindow& f, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const std::uint8_t camera = f.rig.frame_camera;
  const Pose T_body_cam = f.window->T_body_cam(camera, f.rig);
  std::normal_distribution<double> noise(0.0,
                                         1.0 / f.settings.weight_of(FeatureKind::kLine, camera));
  const Pose T_world_middle = f.window->state(f.window->size() / 2).x.T_world_body() * T_body_cam;
  const LineBook book(f.rig, f.settings, 4);
  for (std::size_t tries = 0; f.window->lines.size() < count && tries < 50 * count; ++tries) {
    const auto place = [&] {
      return T_world_middle *
             Eigen::Vector3d(1.5 * unit(random), unit(random), 4.0 + 1.5 * unit(random));
    };
    const Eigen::Vector3d a = place(), b = place();
    LineLandmark line;
    line.id = static_cast<FeatureId>(kFirstImageLineId + tries);
    for (std::size_t k = 0; k < f.window->size(); ++k) {
      const Pose T_cam_world = (f.window->state(k).x.T_world_body() * T_body_cam).inverse();
      const Eigen::Vector3d a_c = T_cam_world * a, b_c = T_cam_world * b;
      if (!(a_c.z() > 0.5 && b_c.z() > 0.5)) continue;
      LineObservation seen;
      seen.state = static_cast<std::uint8_t>(k);
      seen.camera = camera;
      seen.start_xy = {a_c.x() / a_c.z() + noise(random), a_c.y() / a_c.z() + noise(random)};
      seen.end_xy = {b_c.x() / b_c.z() + noise(random), b_c.y() / b_c.z() + noise(random)};
      REQUIRE(line.observations.push_back(seen));
    }
    if (line.observations.size() < 4) continue;
    REQUIRE(f.window->lines.push_back(line));
    (void)book.prepare(*f.window);
    if (!f.window->lines.back().has_line) f.window->lines.pop_back();  // motion along it
  }
  REQUIRE(f.window->lines.size() == count);
}

Eigen::MatrixXd null_space(const SlidingWindow& window, int dim, bool first_estimates) {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(dim, 4);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (std::size_t i = 0; i < window.size(); ++i) {
    const NavState& x = window.state(i).linearisation(first_estimates);
    const int row = static_cast<int>(i) * kStateDim;
    N.block<3, 3>(row, 0).setIdentity();
    N.block<3, 1>(row, 3) = up.cross(x.p_wb);
    N.block<3, 1>(row + 3, 3) = x.q_wb.conjugate() * up;
    N.block<3, 1>(row + 6, 3) = up.cross(x.v_wb);
  }
  return N;
}

double leak(NormalEquations& equations, const Eigen::MatrixXd& N) {
  double worst = 0;
  for (int k = 0; k < 4; ++k) {
    const Eigen::VectorXd n = N.col(k);
    const double scale = (n.cwiseAbs2().cwiseProduct(equations.H().diagonal())).sum();
    worst = std::max(worst, std::abs(n.dot(equations.H() * n)) / scale);
  }
  return worst;
}

void disturb(SlidingWindow& window, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < window.size(); ++i) {
    Vector15d d;
    for (int k = 0; k < 15; ++k)
      d[k] = 0.02 * (2.0 * static_cast<double>(random() >> 11) * 0x1.0p-53 - 1.0);
    d.tail<6>() *= 0.01;
    const Timestamp t = window.state(i).x.t;
    window.state(i).x = box_plus(window.state(i).x, d);
    window.state(i).x.t = t;
  }
}

}  // namespace pled::support
