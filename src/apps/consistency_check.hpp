#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace pled::apps {

/// Normalised estimation error squared (NEES) of the newest pose, 6 degrees of freedom: of an
/// estimator whose covariance is right it is chi^2 distributed, with mean 6.
struct Consistency {
  int runs = 0;
  std::vector<double> nees;     ///< mean over the runs at each frame
  double mean = 0;              ///< over runs and time
  double lower = 0, upper = 0;  ///< 95 % of chi^2 with 6 * runs dof, over runs: for one instant
  double share_inside = 0;      ///< of instants

  /// The mean over time varies less than that of one instant, so an estimator that is
  /// consistent passes more often than 95 times in a hundred.
  [[nodiscard]] bool passed() const noexcept { return mean >= lower && mean <= upper; }
};

struct ConsistencyOptions {
  int runs = 20;            ///< >= 1
  double duration_s = 5.0;  ///< of each run, > 0.5
  int jobs = 1;             ///< threads, >= 1; the result does not depend on it
  std::uint64_t first_seed = 1;
};

/// Runs as many static worlds of noisy point tracks, with consecutive seeds, each started from
/// the truth disturbed by a known prior; the estimator is told the noise that is simulated.
/// @param done  called after each run with the number of finished runs, one call at a time, from
///              any of the threads; may be empty.
[[nodiscard]] Consistency check_consistency(const ConsistencyOptions& options,
                                            const std::function<void(int)>& done = {});

}  // namespace pled::apps
