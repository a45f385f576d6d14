#include "src/report/features_file.hpp"

#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "unit/config/text_file.hpp"

namespace {

using namespace pled::report;
using pled::support::TextFile;

constexpr const char* kHeader =
    "t,id,kind,u0_px,v0_px,u1_px,v1_px,w_temporal,w_geometric,w,observations,used\n";
constexpr const char* kGood = "0.050000000,7,image_point,12.5,100.25,,,,0.250000,0.250000,4,1\n";

/// Reads to the end; what was wrong, or nothing.
std::string fault_of(const std::string& text) {
  const TextFile file("features.csv", text);
  FeaturesFile rows(file.path());
  while (rows.next()) {
  }
  return rows.error() ? rows.error()->message() : "";
}

TEST_SUITE("report.features_file") {
  TEST_CASE("points, lines and cues without evidence are read as they were written") {
    const TextFile file("features.csv",
                        std::string(kHeader) + kGood + "0.100000000,9,line,1,2,3,4,0.5,,,0,0\r\n");
    FeaturesFile rows(file.path());
    const auto point = rows.next();
    REQUIRE(point);
    CHECK(point->stamp_ns == 50'000'000);
    CHECK(point->id == 7);
    CHECK(point->begin_px[1] == 100.25);
    CHECK(std::isnan(point->end_px[0]));
    CHECK(std::isnan(point->w_temporal));
    CHECK(point->w == 0.25);
    CHECK(point->observations == 4);
    CHECK(point->used);
    const auto line = rows.next();
    REQUIRE(line);
    CHECK(line->kind == Kind::kLine);
    CHECK(line->end_px[1] == 4.0);
    CHECK(line->w_temporal == 0.5);
    CHECK(std::isnan(line->w));
    CHECK_FALSE(rows.next());
    CHECK_FALSE(rows.error());
  }

  TEST_CASE("what events showed is known by kind and id") {
    FeatureRow row;
    row.kind = Kind::kEventPoint;
    CHECK(is_of_events(row));
    row.kind = Kind::kLine;
    row.id = pled::kFirstEventLineId;
    CHECK(is_of_events(row));
    row.id = pled::kFirstImageLineId;
    CHECK_FALSE(is_of_events(row));
    row.kind = Kind::kImagePoint;
    row.id = 7;
    CHECK_FALSE(is_of_events(row));
  }

  TEST_CASE("a line that does not read is named with its number") {
    for (const char* bad : {
             "0.1,8,image_point,1,2,,,,0.5,0.5,4\n",                // a column short
             "0.1,8,image_point,1,2,,,,0.5,0.5,4,1,\n",             // a column more
             "later,8,image_point,1,2,,,,0.5,0.5,4,1\n",            // no time
             "0.1,-8,image_point,1,2,,,,0.5,0.5,4,1\n",             // no id
             "0.1,8,corner,1,2,,,,0.5,0.5,4,1\n",                   // no kind
             "0.1,8,image_point,,2,,,,0.5,0.5,4,1\n",               // no place
             "0.1,8,line,1,2,,,,0.5,0.5,4,1\n",                     // a line with one end
             "0.1,8,image_point,1,2,,,,nan,0.5,4,1\n",              // not finite
             "0.1,8,image_point,1,2,,,,0.5,0.5,many,1\n",           // no count
             "0.1,8,image_point,1,2,,,,0.5,0.5,4,yes\n",            // neither 0 nor 1
             "0.01,8,image_point,1,2,,,,0.5,0.5,4,1\n",             // the time goes back
             "\n", "0.1,8,image_point,1,2,,,,0.5,0.5,4,1 # note\n"  // nothing, too much
         }) {
      CAPTURE(bad);
      const std::string fault = fault_of(std::string(kHeader) + kGood + bad + kGood);
      CHECK_MESSAGE(fault.find("features.csv:3: ") != std::string::npos, fault);
    }
  }

  TEST_CASE("a file that was cut, is empty, of another kind or missing is refused") {
    const std::string whole = std::string(kHeader) + kGood + kGood;
    CHECK(fault_of(whole).empty());
    CHECK(fault_of(kHeader).empty());
    const std::string cut = fault_of(whole.substr(0, whole.size() - 1));
    CHECK_MESSAGE(cut.find("features.csv:3: ") != std::string::npos, cut);
    CHECK_MESSAGE(cut.find("cut off") != std::string::npos, cut);
    CHECK(fault_of("").find("empty") != std::string::npos);
    CHECK(fault_of("t,x,y\n").find("features.csv:1: ") != std::string::npos);
    FeaturesFile missing("/nowhere/features.csv");
    CHECK_FALSE(missing.next());
    REQUIRE(missing.error());
    CHECK(missing.error()->message().find("No such file") != std::string::npos);
  }
}

}  // namespace
