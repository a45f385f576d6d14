#include "pled_vins/events/turn_history.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <doctest/doctest.h>

#include "support/events/turning_camera.hpp"

namespace pled {
namespace {

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return so3::log(a.conjugate() * b).norm();
}

}  // namespace

TEST_SUITE("events.turn_history.law") {
  TEST_CASE("rotations are those of the motion, at any two instants, in the camera's frame") {
    const support::TurningBody body;
    const Eigen::Quaterniond R_body_cam = support::slanted_mount();
    const Eigen::Vector3d bias(0.03, -0.02, 0.05);
    // The error is that of a rate taken as linear between samples, which grows with step^2.
    struct Case {
      std::int64_t step_us;
      double bound_rad;
    };
    for (const Case& c : {Case{1000, 2e-5}, Case{5000, 5e-4}, Case{1300, 4e-5}}) {
      CAPTURE(c.step_us);
      TurnHistory turn;
      CHECK(turn.extend(body.samples(0, 900'000, c.step_us, bias), bias, R_body_cam));
      std::mt19937_64 random(1);
      double worst = 0.0;
      for (int i = 0; i < 2000; ++i) {
        const auto a = static_cast<std::int64_t>(random() % 895'000);
        const auto b = static_cast<std::int64_t>(random() % 895'000);
        const std::optional<Eigen::Quaterniond> got = turn.rotation({a}, {b});
        REQUIRE(got);
        worst = std::max(worst, angle_between(*got, body.R_a_b(a, b, R_body_cam)));
      }
      MESSAGE("samples every " << c.step_us << " us: worst error " << worst << " rad");
      CHECK(worst < c.bound_rad);
    }
  }

  TEST_CASE("how samples are split into calls makes no difference to any bit") {
    const support::TurningBody body;
    const Eigen::Vector3d bias(0.01, 0.02, 0.03);
    const std::vector<ImuSample> samples = body.samples(300, 500'000, 997);
    TurnHistory whole;
    whole.extend(samples, bias, support::slanted_mount());
    TurnHistory split;
    const std::span<const ImuSample> all(samples);
    std::size_t begin = 0;
    while (begin + 1 < all.size()) {
      // Neighbouring intervals share an end, as ImuHistory::interval() gives them.
      const std::size_t n = std::min<std::size_t>(all.size() - begin, 2 + begin % 5);
      CHECK(split.extend(all.subspan(begin, n), bias, support::slanted_mount()));
      begin += n - 1;
    }
    REQUIRE(split.newest() == whole.newest());
    for (std::int64_t t = whole.oldest()->us; t <= whole.newest()->us; t += 1111) {
      const Eigen::Quaterniond a = *whole.rotation(*whole.newest(), {t});
      const Eigen::Quaterniond b = *split.rotation(*split.newest(), {t});
      REQUIRE(a.coeffs() == b.coeffs());
    }
  }

  TEST_CASE("what is known of an instant keeps its bits as the gyro goes on") {
    const support::TurningBody body;
    const Eigen::Vector3d bias(0.01, 0.02, 0.03);
    const auto slices = std::make_unique<TurnSlices>();
    for (const std::int64_t step_us : {125, 997, 5000}) {
      CAPTURE(step_us);
      TurnHistory turn;
      std::mt19937_64 random(3);
      struct Seen {
        Timestamp t;
        Eigen::Quaterniond R_ref_t;
        std::array<float, 9> R_ref_slice;
      };
      std::vector<Seen> seen;
      const Timestamp t_ref{10'000};
      // The slices of a span inside one knot's time.
      const auto slice_of = [&](Timestamp t) {
        REQUIRE(turn.slices(t_ref, t, t, 2e-4, *slices));
        return slices->R_ref_slice[slices->index(t.us)];
      };
      for (const ImuSample& sample : body.samples(300, 500'000, step_us, bias)) {
        const std::int64_t before_us = turn.newest().value_or(Timestamp{0}).us;
        turn.extend({&sample, 1}, bias, support::slanted_mount());
        if (before_us < t_ref.us) continue;
        const auto new_us = static_cast<std::uint64_t>(sample.t.us - before_us);
        for (const Timestamp t :
             {Timestamp{before_us + 1 + static_cast<std::int64_t>(random() % new_us)}, sample.t})
          seen.push_back({t, *turn.rotation(t_ref, t), slice_of(t)});
      }
      REQUIRE(seen.size() > 100);
      for (const Seen& s : seen) {
        CAPTURE(s.t.us);
        REQUIRE(turn.rotation(t_ref, s.t)->coeffs() == s.R_ref_t.coeffs());
        REQUIRE(slice_of(s.t) == s.R_ref_slice);
      }
    }
  }

  TEST_CASE("slices keep within the error asked for, at every instant and rate") {
    const Eigen::Quaterniond R_body_cam = support::slanted_mount();
    const auto slices = std::make_unique<TurnSlices>();
    for (const double steady_radps : {0.0, 0.3, 1.0, 3.5}) {
      for (const double asked_rad : {2e-4, 5e-4, 2e-3}) {
        CAPTURE(steady_radps);
        CAPTURE(asked_rad);
        support::TurningBody body;
        body.steady_radps = steady_radps;
        body.swing_rad = 0.05;
        TurnHistory turn;
        turn.extend(body.samples(0, 300'000, 1000), Eigen::Vector3d::Zero(), R_body_cam);
        REQUIRE(turn.slices({300'000}, {180'000}, {300'000}, asked_rad, *slices));
        double worst = 0.0;
        for (std::int64_t t = 180'000; t <= 300'000; t += 17) {
          Eigen::Matrix3f R;
          const std::array<float, 9>& r = slices->R_ref_slice[slices->index(t)];
          R << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
          const Eigen::Quaterniond exact = *turn.rotation({300'000}, {t});
          worst = std::max(worst, angle_between(Eigen::Quaterniond(R.cast<double>()), exact));
        }
        // 64 us are the shortest; nothing here turns so fast that they do not suffice, but for the
        // rounding of float.
        CHECK(worst < 1.01 * asked_rad + 1e-6);
        if (steady_radps > 0.2 && asked_rad < 1e-3) CHECK(worst > 0.2 * asked_rad);
      }
    }
  }
}

}  // namespace pled
