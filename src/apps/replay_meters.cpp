#include "src/apps/replay_meters.hpp"

#include <ctime>

#include "src/apps/allocation_counter.hpp"

namespace pled::apps {
namespace {

double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void ReplayMeters::start() {
  running_ = true;
  allocations_ = allocation_count();
  cpu_s_ = process_cpu_s();
}

void ReplayMeters::stop() {
  if (!running_) return;
  running_ = false;
  cpu_s_ = process_cpu_s() - cpu_s_;
  const auto now = allocation_count();
  if (now && allocations_) allocations_ = *now - *allocations_;
}

}  // namespace pled::apps
