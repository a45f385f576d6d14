#include "src/apps/ablation.hpp"

#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include <doctest/doctest.h>

#include "src/apps/ablation_run.hpp"

namespace pled::apps {
namespace {

using Runs = std::vector<std::optional<double>>;

const Ablation& find(WeightMethod method, bool temporal, bool lines) {
  for (const Ablation& a : kAblations)
    if (a.method == method && a.temporal == temporal && a.lines == lines) return a;
  FAIL("there is no such configuration");
  return kAblations.front();
}

}  // namespace

TEST_SUITE("apps.ablation") {
  TEST_CASE("no two configurations have the same settings or names, and all settings are valid") {
    std::set<std::string> settings, names;
    for (const Ablation& a : kAblations) {
      const std::string name = std::string(method_name(a)) + " " + std::string(evidence_name(a)) +
                               " " + std::string(features_name(a));
      CAPTURE(name);
      CHECK(names.insert(name).second);
      const std::string yaml = to_documented_yaml(ablated({}, a));
      CHECK(settings.insert(yaml).second);
      CHECK(std::holds_alternative<AppConfig>(parse_config(yaml, name)));
    }
    CHECK(names.size() == 14);  // none, and three methods with and without time; lines or not
  }

  TEST_CASE("the default method with everything is the settings as they were given") {
    AppConfig config;
    config.backend.robust = {RobustMode::kPerObservation, 5.0, 0.3};
    config.backend.fusion.lambda_z = 1.5;
    config.lines.source = LineSource::kFrames;
    const Ablation& all = find(WeightMethod::kDefault, true, true);
    CHECK(to_documented_yaml(ablated(config, all)) == to_documented_yaml(config));
    // Where the settings have neither, a row with them would be one without.
    config.backend.fusion.mode = FusionMode::kNone;
    config.lines.source = LineSource::kNone;
    CHECK(ablated(config, all).backend.fusion.mode == FusionMode::kPrior);
    CHECK(ablated(config, all).lines.source == AppConfig{}.lines.source);
    CHECK(AppConfig{}.lines.source != LineSource::kNone);
  }

  TEST_CASE("what is left out is off, and what others published is what runs under their name") {
    for (const Ablation& a : kAblations) {
      CAPTURE(method_name(a));
      const AppConfig c = ablated({}, a);
      CHECK((c.backend.fusion.mode == FusionMode::kNone) == !a.temporal);
      CHECK((c.lines.source == LineSource::kNone) == !a.lines);
      CHECK((c.backend.robust.mode == RobustMode::kNone) == (a.method == WeightMethod::kNone));
      if (a.method == WeightMethod::kPaper || a.method == WeightMethod::kDynavins) {
        CHECK(c.backend.robust.lambda_w == 2.0);
        CHECK(c.backend.robust.lambda_m == 0.2);
        if (a.temporal) CHECK(c.backend.fusion.mode == FusionMode::kPaper);
      }
    }
    CHECK(ablated({}, find(WeightMethod::kPaper, true, true)).reliability.score ==
          TemporalScore::kPaper);
  }

  TEST_CASE("median and worst of several runs, and one without a figure is worse than any") {
    const Runs runs{0.3, 0.1, 0.2};
    CHECK(*median_and_worst(runs, true).median == 0.2);
    CHECK(*median_and_worst(runs, true).worst == 0.3);
    CHECK(*median_and_worst(runs, false).worst == 0.1);
    const Runs even{0.4, 0.1, 0.2, 0.3};
    CHECK(*median_and_worst(even, true).median == doctest::Approx(0.25).epsilon(1e-12));
    for (const bool high_is_bad : {false, true}) {
      const Runs failed{0.1, std::nullopt, 0.1};
      CHECK(*median_and_worst(failed, high_is_bad).median == 0.1);
      CHECK_FALSE(median_and_worst(failed, high_is_bad).worst);
      const Runs half{0.1, std::nullopt};
      CHECK_FALSE(median_and_worst(half, high_is_bad).median);
      CHECK_FALSE(median_and_worst({}, high_is_bad).median);
    }
  }
}

}  // namespace pled::apps
