#include "pled_vins/pipeline/still_gyro_bias.hpp"

#include <limits>
#include <memory>

#include <doctest/doctest.h>

namespace {

using namespace pled;

std::unique_ptr<ImuHistory> history(double gyro_x_radps) {
  auto imu = std::make_unique<ImuHistory>();
  for (int i = 0; i <= 100; ++i)
    REQUIRE(imu->add({Timestamp{i * 5000}, {gyro_x_radps, 0.0, 0.0}, {0.0, 0.0, 9.81}}));
  return imu;
}

constexpr Timestamp kFrom{100'000};
constexpr Timestamp kTo{150'000};

}  // namespace

TEST_SUITE("pipeline.still_gyro_bias") {
  TEST_CASE("the gyro's mean while the picture stands still is the bias") {
    const auto imu = history(0.077);
    StillGyroBias bias;
    CHECK(bias.gyro_bias_radps().norm() == 0.0);
    bias.observe(*imu, kFrom, kTo, 0.1, 50);
    CHECK(bias.gyro_bias_radps().x() == doctest::Approx(0.077));
  }

  TEST_CASE("a moving picture, few points, or an unknown motion teach nothing") {
    const auto imu = history(0.077);
    StillGyroBias bias;
    bias.observe(*imu, kFrom, kTo, 2.0, 50);
    bias.observe(*imu, kFrom, kTo, 0.1, 3);
    bias.observe(*imu, kFrom, kTo, std::numeric_limits<double>::quiet_NaN(), 50);
    CHECK(bias.gyro_bias_radps().norm() == 0.0);
  }

  TEST_CASE("a fast turn is never taken for a bias, even in front of a frozen picture") {
    const auto imu = history(1.0);
    StillGyroBias bias;
    bias.observe(*imu, kFrom, kTo, 0.0, 50);
    CHECK(bias.gyro_bias_radps().norm() == 0.0);
  }
}
