#include "src/apps/simulated_run.hpp"

#include "pled_vins/backend/solvers.hpp"

namespace pled::apps {

SimulatedRun::SimulatedRun(const sim::PointWorld& world, const BackendConfig& config)
    : world_(world),
      solver_(make_solver(SolverKind::kFixed)),
      backend_(std::make_unique<Backend>(config, world.rig(), *solver_)),
      imu_(std::make_unique<ImuHistory>()),
      output_(std::make_unique<BackendOutput>()) {}

SimulatedRun::~SimulatedRun() = default;

const BackendOutput& SimulatedRun::step(std::size_t k) {
  const FrameMeasurement& frame = world_.frames()[k];
  for (; next_imu_ < world_.imu().size(); ++next_imu_) {
    const ImuSample& sample = world_.imu()[next_imu_];
    if (sample.t > frame.t + Duration{6000}) break;
    if (!lost(sample)) imu_->add(sample);
  }
  backend_->process(frame, *imu_, *output_);
  return *output_;
}

}  // namespace pled::apps
