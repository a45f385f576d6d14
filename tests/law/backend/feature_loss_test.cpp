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
