#include "src/apps/replay_meters.hpp"

#include <ctime>

#include <sys/resource.h>

#include "src/apps/allocation_counter.hpp"

namespace pled::apps {
namespace {

double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::uint64_t process_peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

void ReplayMeters::start() {
  running_ = true;
  allocations_ = allocation_count();
  cpu_s_ = process_cpu_s();
}

void ReplayMeters::stop() {
  peak_rss_bytes_ = process_peak_rss_bytes();
  if (!running_) return;
  running_ = false;
  cpu_s_ = process_cpu_s() - cpu_s_;
  const auto now = allocation_count();
  if (now && allocations_) allocations_ = *now - *allocations_;
}

}  // namespace pled::apps
