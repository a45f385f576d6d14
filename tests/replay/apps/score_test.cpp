// What `score` prints, against the same figures counted by hand from the rows that it exports.

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "drivers/replay/image_reader.hpp"
#include "pled_vins/sim/evt3_encoder.hpp"
#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
using nlohmann::json;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A line of --rows.
struct Row {
  std::string stamp;
  std::string kind;
  double u_px = 0.0, v_px = 0.0;
  bool moving = false, used = false;
  std::map<std::string, double> w;  ///< by mode; NaN: no evidence
  /// Of a line, from features.csv: the rows tell its middle.
  std::array<std::pair<double, double>, 2> ends_px{};
};

std::vector<Row> rows_of(const std::filesystem::path& file) {
  std::vector<Row> rows;
  const std::vector<std::string> lines = lines_of(file);
  REQUIRE(!lines.empty());
  REQUIRE(lines[0] ==
          "t,id,kind,u_px,v_px,moving,used,track_length,w_motion,w_paper,w_count,w_geometric,"
          "w_fused");
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> f = csv_fields(lines[i]);
    REQUIRE_MESSAGE(f.size() == 13, lines[i]);
    Row row{f[0], f[2], std::stod(f[3]), std::stod(f[4]), f[5] == "1", f[6] == "1", {}};
    const auto weight = [](const std::string& text) {
      return text.empty() ? kNan : std::stod(text);
    };
    row.w = {{"motion", weight(f[8])},
             {"paper", weight(f[9])},
             {"count", weight(f[10])},
             {"geometric", weight(f[11])},
             {"fused", weight(f[12])}};
    rows.push_back(row);
  }
  return rows;
}

/// The figures by their definitions: every pair of a point at rest and a moving one is compared.
struct Figures {
  double auc = kNan, mae = kNan, mae_balanced = kNan, w_ratio = kNan, w_static = kNan;
  std::size_t n_static = 0, n_dynamic = 0;
};

Figures figures_of(const std::vector<Row>& rows, const std::string& mode, const std::string& kind,
                   const std::string& set) {
  std::vector<double> still, moving;
  for (const Row& row : rows) {
    const double w = row.w.at(mode);
    const bool in_all = !std::isnan(row.w.at("motion")) && !std::isnan(row.w.at("paper")) &&
                        !std::isnan(row.w.at("count"));
    if (row.kind != kind || std::isnan(w) || (set == "used" && !row.used) ||
        (set == "common" && !in_all))
      continue;
    (row.moving ? moving : still).push_back(w);
  }
  Figures f{.n_static = still.size(), .n_dynamic = moving.size()};
  const auto n_still = static_cast<double>(still.size());
  const auto n_moving = static_cast<double>(moving.size());
  double still_sum = 0.0, moving_sum = 0.0, won = 0.0;
  for (const double w : still) still_sum += w;
  for (const double w : moving) moving_sum += w;
  for (const double s : still)
    for (const double m : moving) won += s > m ? 1.0 : s == m ? 0.5 : 0.0;
  if (n_still + n_moving > 0) f.mae = (n_still - still_sum + moving_sum) / (n_still + n_moving);
  if (!still.empty()) f.w_static = still_sum / n_still;
  if (still.empty() || moving.empty()) return f;
  f.auc = won / (n_still * n_moving);
  f.mae_balanced = 0.5 * ((n_still - still_sum) / n_still + moving_sum / n_moving);
  if (moving_sum > 0) f.w_ratio = (still_sum / n_still) / (moving_sum / n_moving);
  return f;
}

void check_figure(const json& printed, double expected) {
  CHECK(printed.is_null() == std::isnan(expected));
  if (printed.is_number()) CHECK(printed.get<double>() == doctest::Approx(expected).epsilon(1e-8));
}

/// Counts the rows whose label is not that of the mask pixel nearest to them, or of a line that of
/// most pixels at its ends and its middle.
std::size_t wrong_labels(const RecordingCopy& recording, const std::vector<Row>& rows) {
  std::map<std::string, std::string> masks;
  for (const std::string& line : recording.lines("masks.txt")) {
    const std::size_t space = line.find(' ');
    masks[line.substr(0, space)] = line.substr(space + 1);
  }
  constexpr std::size_t kWidth = 240, kHeight = 180;
  pled::replay::ImageReader reader({kWidth, kHeight}, true);
  std::vector<std::uint8_t> mask(kWidth * kHeight);
  std::string shown;
  std::size_t wrong = 0;
  for (const Row& row : rows) {
    if (row.stamp != shown) {
      REQUIRE_MESSAGE(masks.contains(row.stamp), row.stamp);
      REQUIRE(reader.read((recording.path() / masks[row.stamp]).c_str(), mask).ok());
      shown = row.stamp;
    }
    const auto is_moving = [&](double u_px, double v_px) {
      const auto x = static_cast<std::size_t>(std::lround(u_px));
      const auto y = static_cast<std::size_t>(std::lround(v_px));
      REQUIRE(x < kWidth);
      REQUIRE(y < kHeight);
      return mask[y * kWidth + x] == 255;
    };
    if (row.kind != "line") {
      if (is_moving(row.u_px, row.v_px) != row.moving) ++wrong;
      continue;
    }
    int moving = is_moving(row.u_px, row.v_px) ? 1 : 0;
    for (const auto& [u_px, v_px] : row.ends_px) moving += is_moving(u_px, v_px) ? 1 : 0;
    if ((moving >= 2) != row.moving) ++wrong;
  }
  return wrong;
}

/// A recording where things move, scored once.
struct Scored {
  RecordingCopy recording{RecordingCopy::Scene::kWithMovers};
  json tables;
  std::vector<Row> rows;

  Scored() {
    const std::filesystem::path file = recording.path().parent_path() / "rows.csv";
    const Outcome o =
        run_pled_vins({"score", recording.path().string(), "--json", "--rows", file.string()});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    tables = json::parse(o.out);  // of the whole output: there is nothing else
    rows = rows_of(file);
  }
};

const Scored& scored() {
  static const Scored it;
  return it;
}

/// The rows of features.csv after a replay of the same recording, by column.
const std::vector<std::vector<std::string>>& replayed_features() {
  static const std::vector<std::vector<std::string>> features = [] {
    const RecordingCopy& recording = scored().recording;
    const Outcome o = recording.replay();
    REQUIRE_MESSAGE(o.code == 0, o.err);
    std::vector<std::vector<std::string>> fields;
    for (const std::string& line : lines_of(recording.out() / "features.csv"))
      fields.push_back(csv_fields(line));
    fields.erase(fields.begin());  // the names
    return fields;
  }();
  return features;
}

TEST_SUITE("apps.score") {
  TEST_CASE(
      "there is a row for each weight and kind of feature, over all rows, used and common ones") {
    const json& tables = scored().tables;
    REQUIRE(tables.is_array());
    std::set<std::string> expected, seen;
    for (const char* mode : {"motion", "paper", "count", "geometric", "fused"})
      for (const char* kind : {"image_point", "event_point", "line"})
        for (const char* rows : {"all", "used", "common"})
          expected.insert(std::string(mode) + " " + kind + " " + rows);
    for (const json& t : tables) {
      for (const char* key : {"sequence", "mode", "kind", "rows", "auc", "mae", "mae_balanced",
                              "w_ratio", "w_static", "n_static", "n_dynamic", "n_no_evidence"})
        REQUIRE_MESSAGE(t.contains(key), key);
      CHECK(t["sequence"] == "recording");  // the folder's name
      seen.insert(t["mode"].get<std::string>() + " " + t["kind"].get<std::string>() + " " +
                  t["rows"].get<std::string>());
    }
    CHECK(seen == expected);
    CHECK(tables.size() == expected.size());
  }

  TEST_CASE("every figure is what its definition gives from the exported rows") {
    std::size_t moving = 0;
    for (const json& t : scored().tables) {
      CAPTURE(t.dump());
      const Figures f = figures_of(scored().rows, t["mode"], t["kind"], t["rows"]);
      CHECK(t["n_static"] == f.n_static);
      CHECK(t["n_dynamic"] == f.n_dynamic);
      check_figure(t["auc"], f.auc);
      check_figure(t["mae"], f.mae);
      check_figure(t["mae_balanced"], f.mae_balanced);
      check_figure(t["w_ratio"], f.w_ratio);
      check_figure(t["w_static"], f.w_static);
      moving += f.n_dynamic;
    }
    CHECK(moving > 500);  // else nothing was told from anything
  }

  TEST_CASE("a label is that of the mask pixel nearest, of a line that of most of three") {
    std::vector<Row> rows = scored().rows;
    CHECK(rows.size() > 5000);
    const std::vector<std::vector<std::string>> features = replayed_features();
    REQUIRE(features.size() == rows.size());
    std::size_t lines = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::vector<std::string>& f = features[i];
      if (rows[i].kind != "line") continue;
      rows[i].ends_px = {{{std::stod(f[3]), std::stod(f[4])}, {std::stod(f[5]), std::stod(f[6])}}};
      const auto& [from, to] = rows[i].ends_px;
      REQUIRE(std::abs(rows[i].u_px - 0.5 * (from.first + to.first)) < 2e-4);
      REQUIRE(std::abs(rows[i].v_px - 0.5 * (from.second + to.second)) < 2e-4);
      ++lines;
    }
    CHECK(lines > 20);
    // Four decimals are written: what lies between two pixels may have been rounded over.
    CHECK(wrong_labels(scored().recording, rows) <= 4);
  }

  TEST_CASE("the default score tells moving points from still ones, whatever the sequence") {
    for (const json& t : scored().tables) {
      if (t["mode"] != "motion" || t["kind"] == "line" || t["rows"] != "all") continue;
      CAPTURE(t.dump());
      CHECK(t["auc"] > 0.8);  // 0.93 were seen: a broken cue is to be told, not one a little worse
    }
  }

  TEST_CASE("the weights of the default score, of geometry and of both are those of features.csv") {
    const std::vector<std::vector<std::string>> features = replayed_features();
    REQUIRE(features.size() == scored().rows.size());
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::vector<std::string>& f = features[i];
      const Row& row = scored().rows[i];
      CAPTURE(i);
      REQUIRE(f[0] == row.stamp);
      REQUIRE(f[2] == row.kind);
      for (const auto& [column, mode] :
           {std::pair{7U, "motion"}, std::pair{8U, "geometric"}, std::pair{9U, "fused"}}) {
        const double w = row.w.at(mode);
        REQUIRE(f[column].empty() == std::isnan(w));
        if (!f[column].empty()) REQUIRE(std::abs(std::stod(f[column]) - w) < 1e-6);
      }
      REQUIRE((f[11] == "1") == row.used);
    }
  }

  TEST_CASE("a stream that breaks fails the run and is told, with the figures up to there") {
    const RecordingCopy recording(RecordingCopy::Scene::kWithMovers);
    const std::filesystem::path events = recording.path() / "events.raw";
    const Outcome o = run_on_broken_disk({"score", recording.path().string(), "--json"}, events,
                                         std::filesystem::file_size(events) / 2);
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "reading the events failed before the end"), o.err);
    const json tables = json::parse(o.out);
    REQUIRE(!tables.empty());
    CHECK(tables[0]["n_static"] > 100);
  }

  TEST_CASE("without labels it says what is missing and prints no figure") {
    const RecordingCopy recording;
    recording.remove("masks.txt");
    const Outcome o = run_pled_vins({"score", recording.path().string(), "--json"});
    CHECK(o.code == 1);
    CHECK(o.out == "");
    CHECK_MESSAGE(contains(o.err, "masks.txt"), o.err);
    CHECK_MESSAGE(contains(o.err, recording.path().string()), o.err);
  }

  TEST_CASE("labels that cannot be read are told before anything is played") {
    const RecordingCopy recording;
    std::filesystem::remove_all(recording.path() / "masks");
    const std::filesystem::path rows = recording.path().parent_path() / "rows.csv";
    const Outcome o =
        run_pled_vins({"score", recording.path().string(), "--json", "--rows", rows.string()});
    CHECK(o.code == 1);
    CHECK(o.out == "");
    CHECK_MESSAGE(contains(o.err, "masks.txt: none of the label images can be read"), o.err);
    CHECK(!std::filesystem::exists(rows));
  }

  TEST_CASE("an event camera that sent nothing is told") {
    const RecordingCopy recording;
    recording.write("events.raw", pled::sim::Evt3Encoder::raw_header(240, 180));
    const Outcome o = run_pled_vins({"score", recording.path().string(), "--json"});
    CHECK_MESSAGE(o.code == 0, o.err);
    CHECK_MESSAGE(contains(o.err, "gave not one event"), o.err);
  }

  TEST_CASE("where nothing moves, what compares two classes is null and not a number") {
    const RecordingCopy recording;
    const Outcome o = run_pled_vins({"score", recording.path().string(), "--json", "--no-events"});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const json tables = json::parse(o.out);
    CHECK(tables.size() == 30);  // of image points and lines; no event point was seen
    for (const json& t : tables) {
      CAPTURE(t.dump());
      CHECK((t["kind"] == "image_point" || t["kind"] == "line"));
      CHECK(t["n_dynamic"] == 0);
      for (const char* key : {"auc", "mae_balanced", "w_ratio"}) CHECK(t[key].is_null());
      // Without events those that count them have no evidence.
      const bool counts_events = t["mode"] == "paper" || t["mode"] == "count";
      CHECK((t["n_static"].get<int>() > 0) == (!counts_events && t["rows"] != "common"));
      CHECK(t["mae"].is_null() == (t["n_static"] == 0));
    }
  }

  TEST_CASE("wrong options exit with 2, and rows that cannot be written with 1") {
    const std::string path = scored().recording.path().string();
    CHECK(run_pled_vins({"score"}).code == 2);
    CHECK(run_pled_vins({"score", path, "--no-frames", "--no-events"}).code == 2);
    const Outcome o = run_pled_vins({"score", path, "--rows", "/nowhere/rows.csv"});
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "/nowhere/rows.csv"), o.err);
    CHECK(run_pled_vins({"score", "/nowhere"}).code == 1);
  }
}

}  // namespace
