#include <cstdio>
#include <cstdlib>

#include "tests/support/simulated_run.hpp"

/// consistency [RUNS [SECONDS]]: mean normalised estimation error squared (NEES) of the newest
/// pose on simulated static scenes, by half second, beside its 95 % bounds. For each instant the
/// sum over N runs is chi^2 with 6 N degrees of freedom when the estimator is consistent, so the
/// mean over the runs lies between the 2.5 % and 97.5 % quantiles divided by N. Exit 0 when
/// the mean over time lies within these bounds, 1 otherwise.
int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 50;
  const double duration_s = argc > 2 ? std::atof(argv[2]) : 10.0;
  if (runs < 1 || !(duration_s > 0.5)) return 2;
  const pled::support::Consistency c = pled::support::check_consistency(runs, duration_s, 1);
  std::printf("# runs %d, %zu frames each, 6 dof, 95%% bounds [%.3f, %.3f]\n", c.runs,
              c.nees.size(), c.lower, c.upper);
  for (std::size_t k = 0; k < c.nees.size(); k += 10)
    std::printf("%.2f\t%.3f\n", 0.05 * static_cast<double>(k), c.nees[k]);
  std::printf("mean NEES %.3f, %.0f%% of instants inside\n", c.mean, 100.0 * c.share_inside);
  return c.mean >= c.lower && c.mean <= c.upper ? 0 : 1;
}
