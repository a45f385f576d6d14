#include "src/imu/imu_step.hpp"

namespace pled::imu_step {
namespace {

bool usable(double distance, double step) noexcept {
  return distance >= 0.5 * step && distance <= 2.0 * step;
}

}  // namespace

Weights weights_at(double u, const ImuSample* before, const ImuSample& start, const ImuSample& end,
                   const ImuSample* after) noexcept {
  const double step = (end.t - start.t).seconds();
  const double to_before = before != nullptr ? (start.t - before->t).seconds() : 0.0;
  const double to_after = after != nullptr ? (after->t - end.t).seconds() : 0.0;
  const bool has_before = usable(to_before, step);
  const bool has_after = usable(to_after, step);
  // Lagrange's weights, with time in steps from `start`: nodes -b, 0, 1, c.
  const double b = to_before / step;
  const double c = 1.0 + to_after / step;
  Weights w;
  if (has_before && has_after) {
    w.before = -u * (u - 1.0) * (u - c) / (b * (b + 1.0) * (b + c));
    w.start = (u + b) * (u - 1.0) * (u - c) / (b * c);
    w.end = (u + b) * u * (u - c) / ((1.0 + b) * (1.0 - c));
    w.after = (u + b) * u * (u - 1.0) / ((c + b) * c * (c - 1.0));
  } else if (has_before) {
    w.before = u * (u - 1.0) / (b * (b + 1.0));
    w.start = -(u + b) * (u - 1.0) / b;
    w.end = (u + b) * u / (1.0 + b);
  } else if (has_after) {
    w.start = (u - 1.0) * (u - c) / c;
    w.end = u * (u - c) / (1.0 - c);
    w.after = u * (u - 1.0) / (c * (c - 1.0));
  } else {
    w.start = 1.0 - u;
    w.end = u;
  }
  return w;
}

}  // namespace pled::imu_step
