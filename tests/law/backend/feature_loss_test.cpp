#include "pled_vins/backend/feature_loss.hpp"

#include <array>
#include <cmath>
#include <span>

#include <doctest/doctest.h>

namespace pled {
namespace {

FactorSettings settings_of(RobustMode mode, FusionMode fusion = FusionMode::kNone) {
  RigCalibration rig;
  rig.num_cameras = 1;
  rig.cameras[0].fx_px = rig.cameras[0].fy_px = 200.0;
  BackendConfig config;
  config.robust.mode = mode;
  config.fusion.mode = fusion;
  return make_factor_settings(config, rig);
}

constexpr std::array kModes{RobustMode::kNone, RobustMode::kPerObservation, RobustMode::kPaper,
                            RobustMode::kDynavins};
constexpr std::array kSquares{0.3, 2.0, 40.0, 0.9, 7.0};

}  // namespace

TEST_SUITE("backend.feature_loss") {
  TEST_CASE("what multiplies a sighting in the equations is the slope of the loss, in each mode") {
    for (const RobustMode mode : kModes) {
      CAPTURE(static_cast<int>(mode));
      const FactorSettings settings = settings_of(mode);
      Reliability reliability;
      weigh(settings, kSquares, reliability);
      for (std::size_t k = 0; k < kSquares.size(); ++k) {
        constexpr double kStep = 1e-5;
        auto more = kSquares, less = kSquares;
        more[k] += kStep;
        less[k] -= kStep;
        const double slope = (feature_cost(settings, more, reliability) -
                              feature_cost(settings, less, reliability)) /
                             kStep;  // of half the loss over two steps
        CHECK(sight_weight(settings, kSquares[k], reliability.w) ==
              doctest::Approx(slope).epsilon(1e-6));
      }
    }
  }

  TEST_CASE("a sighting's loss is its part of the whole") {
    for (const RobustMode mode : kModes) {
      CAPTURE(static_cast<int>(mode));
      const FactorSettings settings = settings_of(mode);
      Reliability reliability;
      weigh(settings, kSquares, reliability);
      auto none = kSquares;
      none[2] = 0.0;
      CHECK(2.0 * (feature_cost(settings, kSquares, reliability) -
                   feature_cost(settings, none, reliability)) ==
            doctest::Approx(sight_loss(settings, kSquares[2], reliability.w)).epsilon(1e-9));
    }
  }

  TEST_CASE("without weights the robust loss of each sighting is left, and of it least squares") {
    BackendConfig config;
    config.robust.mode = RobustMode::kNone;
    RigCalibration rig;
    rig.num_cameras = 1;
    for (const double c : {2.0, 100.0}) {
      CAPTURE(c);
      config.robust_scale = c;
      const FactorSettings settings = make_factor_settings(config, rig);
      Reliability reliability;
      reliability.previous = 0.2;  // weighs in with every other mode, as does
      reliability.temporal = 0.0;  // what time tells
      weigh(settings, kSquares, reliability);
      conclude(settings, false, reliability);
      CHECK(reliability.w == 1.0);
      CHECK(reliability.w_geometric == 1.0);
      double loss = 0.0;
      for (const double s : kSquares) {
        loss += c * c * std::log1p(s / (c * c));
        CHECK(sight_weight(settings, s, reliability.w) ==
              doctest::Approx(settings.sight_gain / (1.0 + s / (c * c))).epsilon(1e-12));
      }
      CHECK(feature_cost(settings, kSquares, reliability) ==
            doctest::Approx(0.5 * settings.sight_gain * loss).epsilon(1e-12));
      // Cauchy's loss with c = 2 takes most of a sighting's say at 6 sigmas; with 100, nothing.
      const double say = sight_weight(settings, 40.0, 1.0) / sight_weight(settings, 0.0, 1.0);
      CHECK(say == doctest::Approx(c < 10.0 ? 1.0 / 11.0 : 1.0).epsilon(0.01));
      // Mistracks are set aside as with weights.
      CHECK(agrees(settings, 0.3));
      CHECK_FALSE(agrees(settings, 0.2));
    }
  }

  TEST_CASE("one wild sighting takes ours less weight than the paper's") {
    std::array<double, 8> squares{};
    squares.fill(1.0);
    squares[3] = 400.0;
    Reliability ours, paper;
    weigh(settings_of(RobustMode::kPerObservation), squares, ours);
    weigh(settings_of(RobustMode::kPaper), squares, paper);
    // Cauchy, c = 2: 4 ln(1 + 100) for it, 4 ln(1.25) for each of the others; momentum 0.1 x 64.
    const double mean = (4.0 * std::log(101.0) + 7.0 * 4.0 * std::log(1.25)) / 8.0;
    const double stiff = 4.0 + 0.1 * 64.0;
    CHECK(ours.w == doctest::Approx(stiff / (stiff + mean)).epsilon(1e-9));
    CHECK(paper.w < 0.1 * ours.w);
  }

  TEST_CASE("what time tells goes into the weight in mode prior, and afterwards in mode paper") {
    Reliability told;
    told.temporal = 0.1;
    told.alpha_line = 0.5;
    for (const FusionMode mode : {FusionMode::kNone, FusionMode::kPrior, FusionMode::kPaper}) {
      CAPTURE(static_cast<int>(mode));
      const FactorSettings settings = settings_of(RobustMode::kPerObservation, mode);
      Reliability point = told, line = told;
      weigh(settings, kSquares, point);
      weigh(settings, kSquares, line);
      CHECK((point.w < point.w_geometric) == (mode == FusionMode::kPrior));
      const double w_ba = point.w;
      conclude(settings, false, point);
      conclude(settings, true, line);
      if (mode == FusionMode::kPaper) {
        const double alpha = 0.4 * std::exp(-std::abs(0.1 - w_ba) / 0.2);  // eq. (14)
        CHECK(point.w == doctest::Approx((1.0 - alpha) * w_ba + alpha * 0.1).epsilon(1e-9));
        CHECK(line.w == doctest::Approx(0.5 * w_ba + 0.5 * 0.1).epsilon(1e-9));  // eq. (13)
      } else {
        CHECK(point.w == w_ba);
      }
      CHECK(point.previous == point.w);
      CHECK(point.rounds == 1);
    }
  }

  TEST_CASE("a track that DynaVINS would leave alone keeps weight 1") {
    const FactorSettings settings = settings_of(RobustMode::kDynavins);
    Reliability reliability;
    weigh(settings, std::span(kSquares).first(3), reliability);
    CHECK(reliability.w == 1.0);
    weigh(settings, std::span(kSquares).first(4), reliability);
    CHECK(reliability.w < 1.0);
  }
}

}  // namespace pled
