#include "pled_vins/config/app_config.hpp"

#include <cmath>
#include <set>
#include <string>

#include <doctest/doctest.h>

#include "pled_vins/config/nearest.hpp"
#include "pled_vins/config/schema.hpp"
#include "unit/config/text_file.hpp"

namespace {

using pled::AppConfig;
using pled::ConfigError;

AppConfig good(const std::string& text) {
  const auto read = pled::parse_config(text, "my.yaml");
  if (const auto* error = std::get_if<ConfigError>(&read)) FAIL(error->message());
  return std::get<AppConfig>(read);
}

ConfigError bad(const std::string& text) {
  CAPTURE(text);
  const auto read = pled::parse_config(text, "my.yaml");
  REQUIRE(std::holds_alternative<ConfigError>(read));
  return std::get<ConfigError>(read);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_SUITE("config.app_config") {
  TEST_CASE("values of every type reach their members, the others keep their defaults") {
    const AppConfig c = good(
        "frontend:\n  max_points: 77\n  ransac_px: 2.5\n"
        "backend: {estimate_time_shift: true, gravity_mps2: 9.7940}\n"
        "sensors:\n  event_camera: cam1\n"
        "robust: {lambda_w: 3}\nfusion: {lambda_z: 0.5}\n"
        "imu: /data/imu.yaml\n");
    CHECK(c.frontend.max_points == 77);
    CHECK(c.frontend.ransac_px == 2.5);
    CHECK(c.backend.estimate_time_shift);
    CHECK(c.backend.gravity_mps2 == 9.794);
    CHECK(c.backend.robust.lambda_w == 3.0);
    CHECK(c.backend.fusion.lambda_z == 0.5);
    CHECK(c.sensors.event_camera == "cam1");
    CHECK(c.sensors.frame_camera == "cam0");
    CHECK(c.sensors_named);
    CHECK(c.calibration.imu == "/data/imu.yaml");
    CHECK(c.backend.max_iterations == pled::BackendConfig{}.max_iterations);
  }

  TEST_CASE("an empty file and an empty section change nothing") {
    CHECK(pled::to_documented_yaml(good("")) == pled::to_documented_yaml({}));
    CHECK(pled::to_documented_yaml(good("frontend:\n")) == pled::to_documented_yaml({}));
    CHECK_FALSE(good("").sensors_named);
  }

  TEST_CASE("a relative calibration path is taken from the file's folder") {
    const pled::support::TextFile file("rig.yaml", "camchain: cams/camchain.yaml\n");
    const auto read = pled::load_config(file.path());
    REQUIRE(std::holds_alternative<AppConfig>(read));
    CHECK(std::get<AppConfig>(read).calibration.camchain ==
          (file.path().parent_path() / "cams/camchain.yaml").string());
  }

  TEST_CASE("an unknown key is an error that names file, line, key and the nearest key") {
    const ConfigError e = bad("frontend:\n  max_points: 50\n  min_distanse_px: 9\n");
    CHECK(e.file == "my.yaml");
    CHECK(e.line == 3);
    CHECK(e.key == "frontend.min_distanse_px");
    CHECK(contains(e.text, "'frontend.min_distance_px'"));
    CHECK(e.message() ==
          "my.yaml:3: frontend.min_distanse_px: unknown key; the nearest is "
          "'frontend.min_distance_px'");
  }

  TEST_CASE("a key in the wrong section and a misspelt section find their home") {
    CHECK(contains(bad("backend:\n  max_points: 50\n").text, "'frontend.max_points'"));
    CHECK(contains(bad("max_points: 50\n").text, "'frontend.max_points'"));
    CHECK(contains(bad("fronted:\n  max_points: 50\n").text, "'frontend'"));
    CHECK(contains(bad("camchian: a.yaml\n").text, "'camchain'"));
  }

  TEST_CASE("a value of the wrong type is an error at its line") {
    struct Case {
      const char* text;
      int line;
      const char* words;
    };
    for (const Case& c : {
             Case{"frontend:\n  max_points: many\n", 2, "whole number, not 'many'"},
             Case{"frontend:\n  max_points: 50.5\n", 2, "whole number"},
             Case{"frontend:\n  max_points: \"50\"\n", 2, "whole number"},
             Case{"frontend:\n  max_points: [50]\n", 2, "not a list"},
             Case{"frontend:\n  max_points:\n", 2, "has no value"},
             Case{"frontend:\n  ransac_px: .nan\n", 2, "must be a number"},
             Case{"frontend:\n  ransac_px: nan\n", 2, "must be a number"},
             Case{"frontend:\n  ransac_px: 1,5\n", 2, "must be a number"},
             Case{"backend:\n  estimate_extrinsic: yes\n", 2, "true or false"},
             Case{"backend: 5\n", 1, "group"},
             Case{"imu: {a: b}\n", 1, "must be text"},
             Case{"- a\n- b\n", 1, "key: value"},
             Case{"events:\n  picture: sharp\n", 2, "must be brightness or time_surface"},
             Case{"reliability: {score: Motion}\n", 1, "must be motion, paper or count"},
             Case{"robust:\n  mode: huber\n", 2,
                  "must be none, per_observation, paper or dynavins"},
             Case{"fusion: {mode: on}\n", 1, "must be none, paper or prior"},
             Case{"lines: {source: all}\n", 1, "must be none, events, frames or both"},
             Case{"lines: {event_picture: sharp}\n", 1, "must be brightness or time_surface"},
         }) {
      const ConfigError e = bad(c.text);
      CHECK(e.line == c.line);
      CHECK_MESSAGE(contains(e.text, c.words), e.message());
    }
  }

  TEST_CASE("a repeated key is an error, not the last one winning") {
    const ConfigError e = bad("frontend:\n  max_points: 50\n  max_points: 60\n");
    CHECK(e.line == 3);
    CHECK(e.key == "frontend.max_points");
    CHECK(contains(e.text, "second time"));
    CHECK(bad("imu: a\nimu: b\n").line == 2);
  }

  TEST_CASE("one key in two spellings and a second document are refused") {
    const ConfigError dotted = bad("frontend.max_points: 100\nfrontend:\n  max_points: 90\n");
    CHECK(dotted.key == "frontend.max_points");
    CHECK(dotted.line == 3);
    CHECK(contains(dotted.text, "second time"));
    const ConfigError second =
        bad("frontend:\n  max_points: 100\n---\nfrontend:\n  max_points: 90\n");
    CHECK(second.line == 4);
    CHECK(contains(second.text, "second document"));
    CHECK(good("---\nfrontend:\n  max_points: 100\n...\n").frontend.max_points == 100);
  }

  TEST_CASE("bad syntax, a missing file, a folder and a binary file are told in words") {
    const ConfigError syntax = bad("frontend:\n  max_points: [1, 2\nbackend: }\n");
    CHECK(syntax.line > 0);
    CHECK(contains(syntax.text, "YAML"));
    const auto missing = pled::load_config("no/such.yaml");
    REQUIRE(std::holds_alternative<ConfigError>(missing));
    CHECK(std::get<ConfigError>(missing).message() == "no/such.yaml: there is no such file");
    CHECK(std::holds_alternative<ConfigError>(pled::load_config(".")));
    const pled::support::TextFile binary("a.yaml", std::string_view("a\0b", 3));
    CHECK(std::holds_alternative<ConfigError>(pled::load_config(binary.path())));
  }

  TEST_CASE("a rule between two values is checked and named") {
    const ConfigError e = bad("backend:\n  init_min_span_s: 3\n\n  init_max_span_s: 1\n");
    CHECK(e.key == "backend.init_max_span_s");
    CHECK(e.line == 4);
    CHECK(contains(e.text, "init_min_span_s"));

    const ConfigError crowded = bad("frontend: {max_points: 100}\nevents: {max_points: 51}\n");
    CHECK(crowded.key == "events.max_points");
    CHECK(crowded.line == 2);
    CHECK(contains(crowded.text, "frontend.max_points"));
    CHECK(good("frontend: {max_points: 100}\nevents: {max_points: 50}\n").events.max_points == 50);
    CHECK(bad("events: {max_points: 19}\n").key == "events.max_points");
  }

  TEST_CASE("every word of a choice is understood, and written as it is read") {
    for (const auto& [score, word] : pled::kTemporalScoreNames) {
      const AppConfig c = good("reliability: {score: " + std::string(word) + "}\n");
      CHECK(c.reliability.score == score);
      CHECK(good(pled::to_documented_yaml(c)).reliability.score == score);
    }
    for (const auto picture : {pled::EventPicture::kBrightness, pled::EventPicture::kTimeSurface}) {
      AppConfig c;
      c.events.picture = picture;
      c.lines.event_picture = picture;
      CHECK(good(pled::to_documented_yaml(c)).events.picture == picture);
      CHECK(good(pled::to_documented_yaml(c)).lines.event_picture == picture);
    }
    for (const auto& [source, word] : pled::kLineSourceNames) {
      const AppConfig c = good("lines: {source: " + std::string(word) + ", max_lines: 12}\n");
      CHECK(c.lines.source == source);
      CHECK(c.lines.tracking.max_lines == 12);
      CHECK(good(pled::to_documented_yaml(c)).lines.source == source);
    }
    for (const auto& [mode, word] : pled::kRobustModeNames) {
      const AppConfig c = good("robust: {mode: " + std::string(word) + "}\n");
      CHECK(c.backend.robust.mode == mode);
      CHECK(good(pled::to_documented_yaml(c)).backend.robust.mode == mode);
    }
    for (const auto& [mode, word] : pled::kFusionModeNames) {
      const AppConfig c = good("fusion: {mode: " + std::string(word) + "}\n");
      CHECK(c.backend.fusion.mode == mode);
      CHECK(good(pled::to_documented_yaml(c)).backend.fusion.mode == mode);
    }
  }

  TEST_CASE("the range of every key is the range that check() knows") {
    for (const pled::ConfigKey& key : pled::config_schema()) {
      CAPTURE(key.key);
      const auto broken = [&](double value) {
        AppConfig c;
        // Rules between two values would answer for their neighbours.
        if (key.key == "backend.init_min_span_s") c.backend.init_max_span_s = 5;
        if (key.key == "backend.init_max_span_s") c.backend.init_min_span_s = 0.2;
        if (key.key == "events.hot_burst") c.events.hot_rate_hz = 1e5;
        if (key.key == "events.hot_rate_hz") c.events.hot_burst = 2;
        const pled::ConfigField field = key.field(c);
        if (auto* const* number = std::get_if<double*>(&field)) **number = value;
        if (auto* const* whole = std::get_if<int*>(&field)) **whole = static_cast<int>(value);
        for (const pled::ConfigIssue issue :
             {check(c.frontend), check(c.events), check(c.lines), check(c.reliability),
              check(c.motion_cue), check(c.backend)})
          if (issue.key != nullptr) return std::string(issue.key);
        return std::string();
      };
      AppConfig defaults;
      const pled::ConfigField field = key.field(defaults);
      const bool whole = std::holds_alternative<int*>(field);
      if (!whole && !std::holds_alternative<double*>(field)) continue;
      const double step = whole ? 1.0 : 1e-9 * std::max(1.0, std::abs(key.high));
      CHECK(broken(key.low) == "");
      CHECK(broken(key.high) == "");
      CHECK(broken(key.low - step) == key.key);
      CHECK(broken(key.high + step) == key.key);
    }
  }

  TEST_CASE("a number outside its range is an error that names the range") {
    for (const pled::ConfigKey& key : pled::config_schema()) {
      if (!(key.high > key.low)) continue;
      CAPTURE(key.key);
      const std::size_t dot = key.key.find('.');
      REQUIRE(dot != std::string_view::npos);
      const std::string text = std::string(key.key.substr(0, dot)) + ":\n  " +
                               std::string(key.key.substr(dot + 1)) + ": 1000000\n";
      const ConfigError e = bad(text);
      CHECK(e.line == 2);
      CHECK(e.key == key.key);
      CHECK(contains(e.text, "1000000 is out of range"));
    }
  }

  TEST_CASE("no two keys share a name or a member, and each has words") {
    AppConfig c;
    std::set<std::string_view> names;
    std::set<const void*> members;
    for (const pled::ConfigKey& key : pled::config_schema()) {
      CAPTURE(key.key);
      CHECK(names.insert(key.key).second);
      CHECK(
          members
              .insert(std::visit([](auto* p) { return static_cast<const void*>(p); }, key.field(c)))
              .second);
      CHECK(key.doc.size() > 10);
    }
  }

  TEST_CASE("the documented YAML reads back as the same settings") {
    AppConfig c;
    c.frontend.max_points = 33;
    c.backend.time_shift_sigma_s = 0.0123456789012345;
    c.backend.estimate_extrinsic = true;
    c.calibration.imu = "/a \"b\"/c\\d.yaml";
    const std::string text = pled::to_documented_yaml(c);
    CHECK(pled::to_documented_yaml(good(text)) == text);
    CHECK(good(text).backend.time_shift_sigma_s == c.backend.time_shift_sigma_s);
    CHECK(good(text).calibration.imu == c.calibration.imu);
  }

  TEST_CASE("configs/default.yaml is the built-in defaults, documented") {
    CHECK(pled::support::read_all(PLED_SOURCE_DIR "/configs/default.yaml") ==
          pled::to_documented_yaml({}));
  }

  TEST_CASE("edit distance counts a swap of neighbours as one mistake") {
    CHECK(pled::edit_distance("", "abc") == 3);
    CHECK(pled::edit_distance("kitten", "sitting") == 3);
    CHECK(pled::edit_distance("replya", "replay") == 1);
    CHECK(pled::nearest("anything", {}).empty());
  }
}

}  // namespace
