#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "pled_vins/backend/backend.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/sim/point_world.hpp"

namespace pled::apps {

/// A back end fed with a simulated world, frame by frame.
class SimulatedRun {
 public:
  SimulatedRun(const sim::PointWorld& world, const BackendConfig& config);
  SimulatedRun(const SimulatedRun&) = delete;
  SimulatedRun& operator=(const SimulatedRun&) = delete;
  ~SimulatedRun();

  /// True for inertial samples that never arrive.
  std::function<bool(const ImuSample&)> lost = [](const ImuSample&) { return false; };

  /// Feeds frame k (in order, all of them) with the inertial data up to it.
  const BackendOutput& step(std::size_t k);
  [[nodiscard]] Backend& backend() { return *backend_; }

 private:
  const sim::PointWorld& world_;
  std::unique_ptr<WindowSolver> solver_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<ImuHistory> imu_;
  std::unique_ptr<BackendOutput> output_;
  std::size_t next_imu_ = 0;
};

}  // namespace pled::apps
