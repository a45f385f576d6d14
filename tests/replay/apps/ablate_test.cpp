// What `ablate` prints, against `replay` and `score` with the settings of its rows.

#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
using nlohmann::json;

/// A recording where things move, run once through all configurations.
struct Ablated {
  RecordingCopy recording{RecordingCopy::Scene::kWithMovers};
  json rows;

  Ablated() {
    const Outcome o = run_pled_vins({"ablate", recording.path().string(), "--json"});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    rows = json::parse(o.out);  // of the whole output: there is nothing else
  }

  [[nodiscard]] const json& row(std::string_view method, std::string_view weights_from,
                                std::string_view features) const {
    for (const json& r : rows)
      if (r["method"] == method && r["weights_from"] == weights_from && r["features"] == features)
        return r;
    FAIL("there is no such row");
    return rows[0];
  }
};

const Ablated& ablation() {
  static const Ablated it;
  return it;
}

/// accuracy of report.json after a replay with these settings.
json accuracy_with(const RecordingCopy& recording, const std::string& settings) {
  const std::filesystem::path file = recording.path().parent_path() / "settings.yaml";
  std::ofstream(file) << settings;
  const Outcome o = recording.replay({"--config", file.string()});
  REQUIRE_MESSAGE(o.code == 0, o.err);
  return json::parse(recording.report())["accuracy"];
}

void check_accuracy(const json& row, const json& accuracy) {
  REQUIRE(row["ate_rmse_m"].is_number());
  // trajectory.tum has nine decimals, ablate all of them.
  CHECK(row["ate_rmse_m"].get<double>() ==
        doctest::Approx(accuracy["ate_rmse_m"].get<double>()).epsilon(1e-5));
  CHECK(row["coverage"].get<double>() ==
        doctest::Approx(accuracy["coverage"].get<double>()).epsilon(1e-6));
}

/// So few frames that nothing starts, and 14 runs take a moment.
RecordingCopy& cut_short(RecordingCopy& recording) {
  std::vector<std::string> frames = recording.lines("images.txt");
  REQUIRE(frames.size() > 8);
  frames.resize(8);
  recording.set_lines("images.txt", frames);
  return recording;
}

TEST_SUITE("apps.ablate") {
  TEST_CASE("there is a row for each configuration, of points and lines, all and used") {
    std::set<std::string> seen;
    for (const json& row : ablation().rows) {
      CAPTURE(row.dump());
      CHECK(row["sequence"] == "recording");
      CHECK(row["starts"] == 1);
      CHECK(row["ate_rmse_m"] == row["ate_rmse_m_worst"]);
      CHECK(row["coverage"] == row["coverage_worst"]);
      seen.insert(row["method"].get<std::string>() + " " + row["weights_from"].get<std::string>() +
                  " " + row["features"].get<std::string>());
      REQUIRE(row["weights"].size() == 4);
      for (std::size_t k = 0; k < 4; ++k) {
        const json& q = row["weights"][k];
        CHECK(q["kind"] == (k < 2 ? "point" : "line"));
        CHECK(q["rows"] == (k % 2 == 0 ? "all" : "used"));
        const double n = q["n_static"].get<double>() + q["n_dynamic"].get<double>();
        CHECK(q["mae_of_1"].is_null() == (n == 0));
        if (n > 0)
          CHECK(q["mae_of_1"].get<double>() ==
                doctest::Approx(q["n_dynamic"].get<double>() / n).epsilon(1e-8));
        CHECK(q["mae_balanced_of_1"].is_null() == q["mae_balanced"].is_null());
        if (k >= 2 && row["features"] == "points") CHECK(n == 0);
      }
      CHECK(row["weights"][0]["n_static"] > 1000);
      CHECK(row["weights"][0]["n_dynamic"] > 100);
    }
    CHECK(ablation().rows.size() == 14);
    CHECK(seen.size() == 14);
    CHECK(seen.contains("none none points"));
    CHECK(seen.contains("paper geometric points"));
    CHECK(seen.contains("dynavins geometric+temporal points+lines"));
  }

  TEST_CASE("a row is what replay makes of its settings, whatever ran before in the process") {
    const RecordingCopy& recording = ablation().recording;
    check_accuracy(ablation().row("default", "geometric+temporal", "points+lines"),
                   accuracy_with(recording, ""));
    check_accuracy(ablation().row("none", "none", "points"),
                   accuracy_with(recording,
                                 "robust: {mode: none}\nfusion: {mode: none}\n"
                                 "lines: {source: none}\n"));
    check_accuracy(ablation().row("dynavins", "geometric+temporal", "points+lines"),
                   accuracy_with(recording,
                                 "robust: {mode: dynavins, lambda_w: 2, lambda_m: 0.2}\n"
                                 "fusion: {mode: paper}\n"));
  }

  TEST_CASE("the figures of the weights are those of score, points of both kinds in one") {
    const RecordingCopy& recording = ablation().recording;
    const Outcome o = run_pled_vins({"score", recording.path().string(), "--json"});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const json& row = ablation().row("default", "geometric+temporal", "points+lines");
    for (const json& q : row["weights"]) {
      CAPTURE(q.dump());
      double n_static = 0.0, n_dynamic = 0.0, w_static = 0.0;
      for (const json& t : json::parse(o.out)) {
        const bool is_line = t["kind"] == "line";
        if (t["mode"] != "fused" || t["rows"] != q["rows"] || is_line != (q["kind"] == "line"))
          continue;
        n_static += t["n_static"].get<double>();
        n_dynamic += t["n_dynamic"].get<double>();
        if (t["w_static"].is_number())
          w_static += t["n_static"].get<double>() * t["w_static"].get<double>();
        if (is_line)
          for (const char* key : {"auc", "mae", "mae_balanced", "w_ratio"}) CHECK(q[key] == t[key]);
      }
      CHECK(q["n_static"] == n_static);
      CHECK(q["n_dynamic"] == n_dynamic);
      if (n_static > 0)
        CHECK(q["w_static"].get<double>() == doctest::Approx(w_static / n_static).epsilon(1e-7));
    }
  }

  TEST_CASE("without labels and truth the table has a row for each, with dashes, and says why") {
    RecordingCopy recording;
    cut_short(recording).remove("masks.txt");
    recording.remove("groundtruth.txt");
    const Outcome o = run_pled_vins({"ablate", recording.path().string(), "--used"});
    CHECK_MESSAGE(o.code == 0, o.err);
    CHECK(contains(o.err, "has no labels"));
    CHECK(contains(o.err, "has no truth"));
    CHECK(contains(o.err, "done: "));
    int rows = 0;
    std::size_t begin = 0;
    while (begin < o.out.size()) {
      const std::size_t end = o.out.find('\n', begin);
      const std::string line = o.out.substr(begin, end - begin);
      begin = end + 1;
      const std::string method = line.substr(0, line.find(' '));
      if (method != "none" && method != "default" && method != "paper" && method != "dynavins")
        continue;
      CAPTURE(line);
      CHECK(line.find_first_of("0123456789") == std::string::npos);
      CHECK(contains(line, " - "));
      ++rows;
    }
    CHECK(rows == 14);
  }

  TEST_CASE("what the solve has not seen is judged by time, and not at all with --used") {
    RecordingCopy recording(RecordingCopy::Scene::kWithMovers);
    const std::string path = cut_short(recording).path().string();
    for (const bool used : {false, true}) {
      std::vector<std::string> arguments{"ablate", path};
      if (used) arguments.emplace_back("--used");
      const Outcome o = run_pled_vins(arguments);
      REQUIRE_MESSAGE(o.code == 0, o.err);
      const std::size_t row = o.out.find("default  geometric+temporal points ");
      REQUIRE_MESSAGE(row != std::string::npos, o.out);
      const std::size_t bar = o.out.find('|', row);
      const std::string points = o.out.substr(bar, o.out.find('|', bar + 1) - bar);
      CAPTURE(points);
      CHECK((points.find_first_of("0123456789") == std::string::npos) == used);
    }
  }

  TEST_CASE("several recordings give a table each, and several starts two figures each") {
    RecordingCopy recording(RecordingCopy::Scene::kWithMovers);
    const std::string path = cut_short(recording).path().string();
    const Outcome o = run_pled_vins({"ablate", path, path, "--starts", "2", "--json"});
    CHECK_MESSAGE(o.code == 0, o.err);
    const json rows = json::parse(o.out);
    CHECK(rows.size() == 28);
    for (const json& row : rows) {
      CHECK(row["starts"] == 2);
      CHECK(row["ate_rmse_m"].is_null());  // nothing starts
      CHECK(row["coverage"] == 0.0);
      CHECK(row["weights"].size() == 4);
    }
    // The second recording is played as if the first had never been.
    for (std::size_t k = 0; k < 14; ++k) CHECK(rows[k] == rows[k + 14]);
  }

  TEST_CASE("a stream that breaks fails the run and is told once, with the figures up to there") {
    RecordingCopy recording(RecordingCopy::Scene::kWithMovers);
    cut_short(recording);
    const Outcome o = run_on_broken_disk({"ablate", recording.path().string(), "--json"},
                                         recording.path() / "events.raw", 0x1000);
    CHECK(o.code == 1);
    const std::string words = "reading the events failed before the end";
    const std::size_t first = o.err.find(words);
    REQUIRE_MESSAGE(first != std::string::npos, o.err);
    CHECK(o.err.find(words, first + 1) == std::string::npos);
    CHECK(json::parse(o.out).size() == 14);
  }

  TEST_CASE("misuse exits with 2; what cannot be played is told before anything is") {
    const RecordingCopy recording;
    const std::string path = recording.path().string();
    CHECK(run_pled_vins({"ablate"}).code == 2);
    CHECK(run_pled_vins({"ablate", path, "--starts", "0"}).code == 2);
    CHECK(run_pled_vins({"ablate", path, "--usd"}).code == 2);
    CHECK(run_pled_vins({"ablate", path, "--no-frames", "--no-events"}).code == 2);
    for (const auto& [arguments, words] : std::map<std::vector<std::string>, const char*>{
             {{"ablate", path, "/nowhere"}, "/nowhere"},
             {{"ablate", path, "--starts", "50"}, "lies behind its end"},
             {{"ablate", path, "--config", "/nowhere.yaml"}, "/nowhere.yaml"}}) {
      const Outcome o = run_pled_vins(arguments);
      CHECK(o.code == 1);
      CHECK(o.out == "");
      CHECK_MESSAGE(contains(o.err, words), o.err);
      CHECK_FALSE(contains(o.err, "done: "));
    }
    std::filesystem::remove_all(recording.path() / "masks");
    const Outcome o = run_pled_vins({"ablate", path});
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "masks.txt: none of the label images can be read"), o.err);
  }
}

}  // namespace
