#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include "support/frontend/tracked_scene.hpp"

namespace {

/// Processor time of this thread, so that other programs do not count.
double cpu_us() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

void run(const char* name, double step_m, double roll_rad) {
  using namespace pled;
  const Camera camera = support::davis240_camera(true);
  const support::PlaneScene scene(camera, support::Texture(1, 0.04, 0.5));
  const auto storage = std::make_unique<support::Storage240>();
  const auto tracker = std::make_unique<FrameTracker>(FrontendConfig{}, camera, storage->view());
  std::mt19937_64 random(1);
  FrameMeasurement out;
  std::vector<double> times;
  std::size_t points = 0;
  constexpr int kFrames = 40;
  for (int k = 0; k < kFrames; ++k) {
    const auto image = scene.render(support::pose_at(step_m * k, 0, -1, {0, 0, roll_rad * k}), 180,
                                    30, 2.0, random);
    FrameView frame;
    frame.image = image.view();
    const double start = cpu_us();
    tracker->track(frame, Timestamp{k * 50'000}, so3::exp({0, 0, roll_rad}), out);
    times.push_back(cpu_us() - start);
    points += out.points.size();
  }
  std::sort(times.begin(), times.end());
  std::printf("%-28s %3zu points  p50 %6.0f us  max %6.0f us\n", name,
              points / static_cast<std::size_t>(kFrames), times[times.size() / 2], times.back());
}

}  // namespace

int main() {
  std::printf("FrameTracker::track at 240 x 180, processor time\n");
  run("still", 0.0, 0.0);
  run("3 px per frame", 0.015, 0.0);
  run("3 px and 0.1 rad roll", 0.015, 0.1);
  return 0;
}
