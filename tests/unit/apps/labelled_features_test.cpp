#include "src/apps/labelled_features.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

namespace pled::apps {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

LabelledFeature feature(FeatureKind kind, bool is_moving, bool used, double motion, double paper,
                        double fused) {
  LabelledFeature f{.kind = kind, .is_moving = is_moving, .used = used};
  f.w = {motion, paper, 0.5, kNan, fused};
  return f;
}

}  // namespace

TEST_SUITE("apps.labelled_features") {
  TEST_CASE("a line moves when two of its ends and its middle do") {
    constexpr int kSide = 20;
    std::vector<std::uint8_t> pixels(kSide * kSide, 0);
    const auto paint = [&](int x, int y) { pixels[static_cast<std::size_t>(y * kSide + x)] = 255; };
    const ImageView<const std::uint8_t> labels{pixels.data(), kSide, kSide, kSide};
    const std::array<Eigen::Vector2d, 2> line{Eigen::Vector2d(2.4, 3.6), Eigen::Vector2d(12, 13)};
    CHECK_FALSE(is_line_moving(labels, line));
    paint(7, 8);  // the middle is 7.2, 8.3
    CHECK_FALSE(is_line_moving(labels, line));
    paint(2, 4);
    CHECK(is_line_moving(labels, line));
    // An end off the picture is at rest.
    CHECK_FALSE(is_line_moving(labels, {Eigen::Vector2d(2, 4), Eigen::Vector2d(25, 4)}));
    paint(14, 4);
    CHECK(is_line_moving(labels, {Eigen::Vector2d(2, 4), Eigen::Vector2d(25, 4)}));
  }

  TEST_CASE("a weight is judged on the features of the kinds and the set that are asked for") {
    using enum FeatureKind;
    const std::vector<LabelledFeature> features{
        feature(kImagePoint, false, true, 0.9, kNan, 0.8),
        feature(kImagePoint, true, false, 0.4, 0.1, 0.3),
        feature(kEventPoint, false, false, 0.7, 0.6, kNan),
        feature(kLine, false, true, kNan, kNan, 0.5),
    };
    constexpr std::array kPoints{kImagePoint, kEventPoint};
    const WeightJudgement all = judge_features(features, kPoints, kFusedMode, RowSet::kAll);
    CHECK(all.seen == 3);
    CHECK(all.no_evidence == 1);
    CHECK(all.quality.n_static == 1);
    CHECK(all.quality.n_dynamic == 1);
    CHECK(*all.quality.mae == doctest::Approx(0.5 * (0.2 + 0.3)).epsilon(1e-12));
    CHECK(*all.quality.mae_of_one() == 0.5);
    const WeightJudgement used = judge_features(features, kPoints, kFusedMode, RowSet::kUsed);
    CHECK(used.seen == 3);
    CHECK(used.quality.n_static + used.quality.n_dynamic == 1);
    // Every temporal score knows two of the points; that geometry knows none does not matter.
    const WeightJudgement common = judge_features(features, kPoints, 0, RowSet::kCommon);
    CHECK(common.quality.n_static == 1);
    CHECK(common.quality.n_dynamic == 1);
    CHECK(*common.quality.mean_static == 0.7);
    const WeightJudgement lines =
        judge_features(features, std::array{kLine}, kFusedMode, RowSet::kAll);
    CHECK(lines.seen == 1);
    CHECK(*lines.quality.mean_static == 0.5);
  }
}

}  // namespace pled::apps
