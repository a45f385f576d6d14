#include "pled_vins/evaluation/evaluate.hpp"

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

namespace {

constexpr std::int64_t kMs = 1'000'000;

/// On the x axis at 1 m/s, one pose at each stamp.
pled::Trajectory walk(const std::vector<std::int64_t>& stamps_ms) {
  pled::Trajectory out;
  for (const std::int64_t ms : stamps_ms) {
    pled::Pose pose;
    pose.p = {static_cast<double>(ms) * 1e-3, 0, 0};
    out.push_back({ms * kMs, pose});
  }
  return out;
}

std::vector<std::int64_t> every(std::int64_t first_ms, std::int64_t last_ms, std::int64_t step_ms) {
  std::vector<std::int64_t> out;
  for (std::int64_t ms = first_ms; ms <= last_ms; ms += step_ms) out.push_back(ms);
  return out;
}

bool says(const pled::Evaluation& e, const char* words) {
  for (const std::string& note : e.notes)
    if (note.find(words) != std::string::npos) return true;
  return false;
}

TEST_SUITE("evaluation.evaluate") {
  TEST_CASE("poses outside the truth and inside its gaps are dropped and counted") {
    // Truth 100 ... 1000 ms, with nothing between 300 and 500.
    std::vector<std::int64_t> stamps = every(100, 300, 50);
    for (const std::int64_t ms : every(500, 1000, 50)) stamps.push_back(ms);
    const pled::Trajectory estimate = walk(every(0, 1100, 20));
    const pled::Evaluation e = pled::evaluate(estimate, walk(stamps), std::nullopt);
    CHECK(e.poses == 56);
    CHECK(e.outside_truth == 5 + 5);  // 0 ... 80 and 1020 ... 1100
    CHECK(e.in_truth_gap == 9);       // 320 ... 480
    CHECK(e.matched == 56 - 10 - 9);
    REQUIRE(e.ate_rmse_m);
    CHECK(*e.ate_rmse_m < 1e-12);
  }

  TEST_CASE("a pose exactly on a truth pose counts although a gap begins there") {
    const pled::Evaluation e =
        pled::evaluate(walk({0, 50, 100, 400}), walk({0, 50, 100, 400}), std::nullopt);
    CHECK(e.matched == 4);
    CHECK(e.in_truth_gap == 0);
  }

  TEST_CASE("a truth interval of exactly 0.1 s is no gap, one nanosecond more is") {
    const pled::Trajectory estimate = walk({0, 50, 100});
    pled::Trajectory truth = walk({0, 100, 200});
    CHECK(pled::evaluate(estimate, truth, std::nullopt).matched == 3);
    truth[1].stamp_ns += 1;
    CHECK(pled::evaluate(estimate, truth, std::nullopt).in_truth_gap == 2);
  }

  TEST_CASE("truth is interpolated linearly and by slerp") {
    pled::Trajectory truth(2);
    truth[0].pose.p = {0, 0, 0};
    truth[1].stamp_ns = 100 * kMs;
    truth[1].pose.p = {1, 0, 0};
    // The same rotation with the other sign must not send slerp the long way round.
    truth[1].pose.q = Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ()));
    truth[1].pose.q.coeffs() *= -1.0;
    pled::Trajectory estimate;
    for (const int percent : {0, 25, 50, 100}) {
      pled::Pose pose;
      pose.p = {0.01 * percent, 0, 0};
      pose.q = Eigen::AngleAxisd(0.008 * percent, Eigen::Vector3d::UnitZ());
      estimate.push_back({percent * kMs, pose});
    }
    // Longer than 1 s, so that relative errors exist.
    for (const std::int64_t s : {1, 2}) {
      truth.push_back({s * 1000 * kMs, truth[0].pose});
      estimate.push_back({s * 1000 * kMs, truth[0].pose});
    }
    const pled::Evaluation e = pled::evaluate(estimate, truth, std::nullopt);
    CHECK(e.matched == 6);
    REQUIRE(e.ate_rmse_m);
    CHECK(*e.ate_rmse_m < 1e-12);
    REQUIRE(e.rpe_rot_deg);
    CHECK(*e.rpe_rot_deg < 1e-6);
  }

  TEST_CASE("MPE is the mean error by the length of the truth's own path") {
    // Errors +e, -e, -e, +e across a 3 m path: symmetric, so no rigid motion helps but
    // the mean stays e.
    const double e_m = 0.01;
    pled::Trajectory truth = walk({0, 1000, 2000, 3000});
    pled::Trajectory estimate = truth;
    const double signs[] = {1, -1, -1, 1};
    for (std::size_t i = 0; i < 4; ++i) estimate[i].pose.p.y() += signs[i] * e_m;
    const pled::Evaluation e = pled::evaluate(estimate, truth, std::nullopt);
    CHECK(e.path_m.value() == doctest::Approx(3.0));
    REQUIRE(e.mpe_percent);
    CHECK(*e.mpe_percent == doctest::Approx(100.0 * e_m / 3.0).epsilon(1e-9));
    CHECK(*e.ate_rmse_m == doctest::Approx(e_m).epsilon(1e-9));
  }

  TEST_CASE("the path is told over the evaluated span only, its interpolated ends included") {
    const pled::Evaluation e =
        pled::evaluate(walk({125, 500, 975}), walk(every(0, 5000, 50)), std::nullopt);
    CHECK(e.path_m.value() == doctest::Approx(0.85));
    CHECK(e.span_s.value() == doctest::Approx(0.85));
  }

  TEST_CASE("relative errors pair poses 1 s apart, within half a period") {
    // 300 ms apart: the first pose at or after 850 ms is at 900; 1 s is 100 ms off, and
    // half a period is 150.
    const pled::Trajectory a = walk(every(0, 3000, 300));
    CHECK(pled::evaluate(a, walk(every(0, 3000, 50)), std::nullopt).rpe_pairs == 8);
    // 700 ms apart: 700 ms and 1400 ms; 1 s - 350 ms = 650, so the pair is (0, 700).
    const pled::Trajectory b = walk(every(0, 2800, 700));
    CHECK(pled::evaluate(b, walk(every(0, 3000, 50)), std::nullopt).rpe_pairs == 4);
    // A hole where the partner should be leaves that pose out.
    std::vector<std::int64_t> holed = every(0, 2000, 100);
    std::erase(holed, 1500);
    const pled::Trajectory c = walk(holed);
    CHECK(pled::evaluate(c, walk(every(0, 3000, 50)), std::nullopt).rpe_pairs == 10);
  }

  TEST_CASE("a constant drift gives the relative error of one second") {
    const pled::Trajectory truth = walk(every(0, 5000, 50));
    pled::Trajectory estimate = truth;
    for (pled::StampedPose& pose : estimate) pose.pose.p *= 1.1;  // 10 % of 1 m/s
    const pled::Evaluation e = pled::evaluate(estimate, truth, std::nullopt);
    REQUIRE(e.rpe_trans_m);
    CHECK(*e.rpe_trans_m == doctest::Approx(0.1).epsilon(1e-9));
    CHECK(*e.rpe_rot_deg == doctest::Approx(0.0));
  }

  TEST_CASE("coverage counts intervals of at most two frame periods inside the overlap") {
    const pled::Trajectory truth = walk(every(1000, 9000, 50));
    // Frames 0 ... 10 s every 50 ms: the overlap is 1 ... 9 s.
    const pled::FrameSpan frames{0, 10'000 * kMs, 50 * kMs};
    // Poses from 3 s on: 6 of 8 s.
    CHECK(*pled::evaluate(walk(every(3000, 9500, 50)), truth, frames).coverage ==
          doctest::Approx(6.0 / 8.0));
    // One frame left out makes 100 ms: still covered. Two make 150 ms: not.
    std::vector<std::int64_t> stamps = every(1000, 9000, 50);
    std::erase(stamps, 2000);
    CHECK(*pled::evaluate(walk(stamps), truth, frames).coverage == doctest::Approx(1.0));
    std::erase(stamps, 2050);
    CHECK(*pled::evaluate(walk(stamps), truth, frames).coverage == doctest::Approx(7.85 / 8.0));
    // No pose at all covers nothing.
    const pled::Evaluation none = pled::evaluate({}, truth, frames);
    REQUIRE(none.coverage);
    CHECK(*none.coverage == 0.0);
  }

  TEST_CASE("stamps that jitter by a microsecond do not break an interval of two periods") {
    const pled::Trajectory truth = walk(every(0, 1000, 50));
    pled::Trajectory estimate = walk(every(0, 1000, 100));
    estimate[3].stamp_ns += 1000;
    const pled::Evaluation e =
        pled::evaluate(estimate, truth, pled::FrameSpan{0, 1000 * kMs, 50 * kMs});
    CHECK(*e.coverage == doctest::Approx(1.0));
  }

  TEST_CASE("without frame stamps, coverage is told over the trajectory, and a note says so") {
    const pled::Evaluation e =
        pled::evaluate(walk(every(3000, 5000, 50)), walk(every(1000, 9000, 50)), std::nullopt);
    CHECK(*e.coverage == doctest::Approx(1.0));
    CHECK(says(e, "frame stamps unknown"));
  }

  TEST_CASE("fewer than three matched poses give no accuracy but a reason") {
    const pled::Evaluation e =
        pled::evaluate(walk({0, 50}), walk(every(0, 1000, 50)), std::nullopt);
    CHECK_FALSE(e.ate_rmse_m);
    CHECK_FALSE(e.mpe_percent);
    CHECK_FALSE(e.rpe_trans_m);
    CHECK_FALSE(e.rpe_rot_deg);
    CHECK(says(e, "3 are needed"));
  }

  TEST_CASE("empty inputs and inputs that do not meet give no figures and no crash") {
    CHECK_FALSE(pled::evaluate({}, {}, std::nullopt).coverage);
    const pled::Evaluation apart =
        pled::evaluate(walk({0, 50, 100}), walk({5000, 5050}), std::nullopt);
    CHECK_FALSE(apart.ate_rmse_m);
    CHECK_FALSE(apart.coverage);
    CHECK(apart.outside_truth == 3);
    CHECK(says(apart, "do not overlap"));
  }

  TEST_CASE("a truth that stands still has an ATE but no MPE") {
    pled::Trajectory still = walk({0, 50, 100, 150});
    for (pled::StampedPose& pose : still) pose.pose.p.setZero();
    const pled::Evaluation e = pled::evaluate(still, still, std::nullopt);
    CHECK(e.ate_rmse_m == 0.0);
    CHECK_FALSE(e.mpe_percent);
    CHECK(says(e, "does not move"));
  }

  TEST_CASE("frame_span is first, last and median; one stamp is none") {
    const std::vector<std::int64_t> stamps{0, 10, 20, 90, 100};
    const auto span = pled::frame_span(stamps);
    REQUIRE(span);
    CHECK(span->first_ns == 0);
    CHECK(span->last_ns == 100);
    CHECK(span->period_ns == 10);
    CHECK_FALSE(pled::frame_span(std::vector<std::int64_t>{5}));
  }
}

}  // namespace
