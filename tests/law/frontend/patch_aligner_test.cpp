#include "pled_vins/frontend/patch_aligner.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/frontend/pyramid.hpp"
#include "support/frontend/plane_scene.hpp"

namespace pled {
namespace {

constexpr int kSize = 100;

/// A smooth function of the plane, sampled at A x + b, as a pyramid level with its margin.
class Level {
 public:
  Level(const Eigen::Matrix2d& A, const Eigen::Vector2d& b, double gain, double offset = 20)
      : memory_(pyramid_values(kSize, kSize)),
        row_(static_cast<std::size_t>(padded_stride(kSize))) {
    const support::Texture texture(3, 9.0, 40.0);
    support::GreyImage image(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const Eigen::Vector2d p = A * Eigen::Vector2d(x - 50, y - 50) + b;
        image.at(y, x) =
            static_cast<std::uint8_t>(std::lround(offset + gain * texture(p.x(), p.y())));
      }
    pyramid_ = lay_out_pyramid(memory_, kSize, kSize, 1);
    build_pyramid(image.view(), row_, pyramid_);
  }
  [[nodiscard]] PatchSource source() const { return PatchSource::whole(pyramid_.levels[0]); }

 private:
  std::vector<std::int16_t> memory_;
  std::vector<std::uint16_t> row_;
  Pyramid pyramid_;
};

Eigen::Matrix2d turned(double angle, double scale) {
  return scale * Eigen::Rotation2Dd(angle).toRotationMatrix();
}

}  // namespace

TEST_SUITE("frontend.patch_aligner") {
  TEST_CASE("a patch is found where it went, for every size, turn, scale, gain and shift") {
    const Level first(Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero(), 180);
    for (const int radius : {3, 4, 7, 8, 10}) {
      for (const double angle : {0.0, 0.2, -1.0}) {
        for (const double scale : {1.0, 0.85}) {
          const Eigen::Vector2d shift(0.63, -1.21);
          const Eigen::Matrix2d A = turned(angle, scale);
          const Level second(A, A * shift, 120);  // content at first (50, 50) lies at 50 - shift
          const auto aligner = std::make_unique<PatchAligner>(radius);
          CAPTURE(radius);
          CAPTURE(angle);
          CAPTURE(scale);
          REQUIRE(aligner->set_template(first.source(), {50, 50}, A, second.source(), {50, 50},
                                        PatchModel::kShift, 0.1F));
          Eigen::Vector2d at(50, 50);
          const AlignResult result = aligner->align(second.source(), 30, 0.001, at);
          REQUIRE(result.ok);
          CHECK(result.similarity > 0.99F);
          // The smoothing kernel does not scale with the content: small patches feel it more.
          const double bound_px = scale < 1.0 && radius < 7 ? 0.1 : 0.05;
          CHECK((at - (Eigen::Vector2d(50, 50) - shift)).norm() < bound_px);
        }
      }
    }
  }

  TEST_CASE("a small deformation is reported as the one that was made") {
    const Level first(Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero(), 180);
    Eigen::Matrix2d A;
    A << 1.03, 0.02, -0.01, 0.97;
    const Level second(A, Eigen::Vector2d::Zero(), 180);
    const auto aligner = std::make_unique<PatchAligner>(10);
    REQUIRE(aligner->set_template(first.source(), {50, 50}, Eigen::Matrix2d::Identity(),
                                  second.source(), {50, 50}, PatchModel::kAffine, 0.1F));
    Eigen::Vector2d at(50.3, 49.8);
    const AlignResult result = aligner->align(second.source(), 30, 0.001, at);
    REQUIRE(result.ok);
    CHECK((at - Eigen::Vector2d(50, 50)).norm() < 0.03);
    CHECK((result.deformation - A).cwiseAbs().maxCoeff() < 0.008);
  }

  TEST_CASE("the negative of a patch is found when it is expected, and only then") {
    const Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
    const Eigen::Vector2d shift(0.63, -1.21);
    const Level first(A, Eigen::Vector2d::Zero(), 180);
    const Level positive(A, shift, 120);
    const Level negative(A, shift, -120, 200);
    const Eigen::Vector2d want = Eigen::Vector2d(50, 50) - shift;
    const auto aligner = std::make_unique<PatchAligner>(7);
    for (const bool inverted : {true, false, true}) {
      CAPTURE(inverted);
      aligner->set_inverted(inverted);
      const Level& same = inverted ? negative : positive;
      const Level& other = inverted ? positive : negative;
      REQUIRE(aligner->set_template(first.source(), {50, 50}, A, same.source(), {50, 50},
                                    PatchModel::kShift, 0.1F));
      Eigen::Vector2d at(50, 50);
      const AlignResult result = aligner->align(same.source(), 30, 0.001, at);
      REQUIRE(result.ok);
      CHECK(result.similarity > 0.99F);
      CHECK((at - want).norm() < 0.05);
      CHECK(aligner->similarity(other.source(), want) < -0.99F);
    }
  }

  TEST_CASE("pixels past the image's edge do not pull a patch") {
    const Level first(Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero(), 180);
    const Eigen::Vector2d shift(0.4, 0.3);
    for (const double angle : {0.0, 0.1}) {
      const Eigen::Matrix2d A = turned(angle, 1.0);
      const Level second(A, A * shift, 180);
      for (const Eigen::Vector2d& place : {Eigen::Vector2d(4, 50), Eigen::Vector2d(95, 30),
                                           Eigen::Vector2d(40, 5), Eigen::Vector2d(70, 94)}) {
        CAPTURE(angle);
        CAPTURE(place.x());
        CAPTURE(place.y());
        const Eigen::Vector2d centre(50, 50);
        const Eigen::Vector2d want = A.inverse() * (place - centre) - shift + centre;
        const auto aligner = std::make_unique<PatchAligner>(7);
        if (!aligner->set_template(first.source(), place, A, second.source(), want,
                                   PatchModel::kShift, 0.1F))
          continue;  // turned too far out
        Eigen::Vector2d at = want + Eigen::Vector2d(0.5, -0.4);
        REQUIRE(aligner->align(second.source(), 30, 0.001, at).ok);
        CHECK((at - want).norm() < 0.08);
      }
    }
  }

  TEST_CASE("a patch without texture, or with texture in one direction only, is refused") {
    support::GreyImage stripes(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        stripes.at(y, x) = static_cast<std::uint8_t>(std::lround(128 + 100 * std::sin(0.4 * x)));
    std::vector<std::int16_t> memory(pyramid_values(kSize, kSize));
    std::vector<std::uint16_t> row(static_cast<std::size_t>(padded_stride(kSize)));
    Pyramid pyramid = lay_out_pyramid(memory, kSize, kSize, 1);
    const auto aligner = std::make_unique<PatchAligner>(7);
    for (const bool flat : {false, true}) {
      if (flat) std::fill(stripes.pixels.begin(), stripes.pixels.end(), std::uint8_t{77});
      build_pyramid(stripes.view(), row, pyramid);
      const PatchSource source = PatchSource::whole(pyramid.levels[0]);
      CHECK_FALSE(aligner->set_template(source, {50, 50}, Eigen::Matrix2d::Identity(), source,
                                        {50, 50}, PatchModel::kShift, 0.1F));
    }
  }
}

}  // namespace pled
