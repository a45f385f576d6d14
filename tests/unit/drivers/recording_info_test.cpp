#include "drivers/replay/recording_info.hpp"

#include <algorithm>
#include <cstdio>

#include <doctest/doctest.h>

#include "unit/drivers/evt3_words.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

RecordingInfo survey_of(const std::string& path) {
  Problems problems;
  const auto recording = Recording::open(path, problems);
  REQUIRE(recording.ok());
  const auto info = survey(recording.value(), problems, {});
  REQUIRE(info.ok());
  return info.value();
}

bool says(const RecordingInfo& info, std::initializer_list<const char*> parts) {
  return std::any_of(info.problems.begin(), info.problems.end(), [&](const std::string& words) {
    return std::all_of(parts.begin(), parts.end(),
                       [&](const char* part) { return words.find(part) != std::string::npos; });
  });
}

std::string imu_line(std::int64_t t_us) { return std::to_string(t_us) + "e-6 0 0 9.81 0 0 0\n"; }

/// 200 Hz for `count` samples from `begin_us`.
std::string imu_lines(std::int64_t begin_us, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += imu_line(begin_us + i * 5000);
  return text;
}

}  // namespace

TEST_SUITE("drivers.recording_info") {
  TEST_CASE("a gap of half a second is found, placed and measured") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", imu_lines(0, 200) + imu_lines(1'495'000, 200));
    const RecordingInfo info = survey_of(folder.path());
    CHECK(info.imu.count == 400);
    CHECK(info.imu.rate_hz == doctest::Approx(200.0));
    CHECK(info.imu.gaps == 1);
    CHECK(info.imu.longest_gap_s == doctest::Approx(0.5));
    CHECK(says(info, {"imu.txt", "0.5000", "1.495"}));
  }

  TEST_CASE("a pause up to 25 ms or four medians is no gap, one microsecond more is") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", imu_lines(0, 50) + imu_lines(245'000 + 25'000, 50));
    CHECK(survey_of(folder.path()).imu.gaps == 0);
    write_file(folder / "imu.txt", imu_lines(0, 50) + imu_lines(245'000 + 25'001, 50));
    CHECK(survey_of(folder.path()).imu.gaps == 1);
    std::string slow;
    for (int i = 0; i < 20; ++i) slow += imu_line(i * 10'000);
    write_file(folder / "imu.txt", slow + imu_line(190'000 + 40'000));
    CHECK(survey_of(folder.path()).imu.gaps == 0);
    write_file(folder / "imu.txt", slow + imu_line(190'000 + 40'001));
    CHECK(survey_of(folder.path()).imu.gaps == 1);
  }

  TEST_CASE("repeated and backward stamps and unreadable lines are counted apart") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", imu_lines(0, 100) + imu_line(495'000) + imu_line(480'000) +
                                       "0.5 nan 0 0 0 0 0\n0.5 x\n" + imu_lines(500'000, 10));
    const RecordingInfo info = survey_of(folder.path());
    CHECK(info.imu.count == 112);
    CHECK(info.imu.duplicates == 1);
    CHECK(info.imu.backwards == 1);
    CHECK(info.imu.gaps == 0);
    CHECK(says(info, {"imu.txt line 103"}));
    CHECK(says(info, {"imu.txt line 104"}));
    CHECK(says(info, {"1 repeated stamps"}));
    CHECK(says(info, {"1 stamps that go back"}));
  }

  TEST_CASE("frames are counted when they are readable and in order") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 9, 8);
    write_grey_png(folder / "cut.png", 9, 8);
    truncate_file(folder / "cut.png", 0.6);
    write_file(folder / "images.txt", std::string("1.0 a.png\n1.05 a.png\n1.05 a.png\n1.1 cut.png\n"
                                                  "1.15 a.png\n1.2 a.png\n"));
    const RecordingInfo info = survey_of(folder.path());
    CHECK(info.frames.count == 4);
    CHECK(info.frames.first_s == doctest::Approx(1.0));
    CHECK(info.frames.last_s == doctest::Approx(1.2));
    CHECK(info.frames.rate_hz == doctest::Approx(15.0));
    CHECK(info.frames.width == 9);
    CHECK(info.frames.height == 8);
    CHECK(says(info, {"cut.png", "line 4"}));
    CHECK(says(info, {"images.txt", "1 frames whose stamp"}));
    CHECK_FALSE(info.imu.present);
    CHECK_FALSE(info.events.present);
  }

  TEST_CASE("events outside the sensor are counted, not given") {
    const TemporaryFolder folder;
    const std::string header = "% evt 3.0\n% geometry 240x180\n% end\n";
    std::vector<std::byte> bytes;
    for (const char c : header) bytes.push_back(static_cast<std::byte>(c));
    const auto body = wire({time_high(0), addr_y(1), cd(1, Polarity::kOn), cd(300, Polarity::kOn),
                            addr_y(200), cd(1, Polarity::kOn), time_high(1), time_low(904),
                            addr_y(2), vect_base(0, Polarity::kOff), vect_12(7)});
    bytes.insert(bytes.end(), body.begin(), body.end());
    write_file(folder / "one.raw", bytes);
    const RecordingInfo info = survey_of(folder / "one.raw");
    CHECK(info.events.count == 4);
    CHECK(info.events.first_s == 0.0);
    CHECK(info.events.last_s == doctest::Approx(0.005));
    CHECK(info.events.rate_hz == doctest::Approx(800.0));
    CHECK(info.events.width == 240);
    CHECK(info.events.height == 180);
    CHECK(says(info, {"one.raw", "2 events outside the sensor"}));
  }

  TEST_CASE("one text file of events is surveyed without a known size") {
    const TemporaryFolder folder;
    write_file(folder / "events.txt", std::string("0.5 3 4 1\n0.6 1999 4 1\ntext\n0.7 3 4 0"));
    const RecordingInfo info = survey_of(folder / "events.txt");
    CHECK(info.events.count == 3);
    CHECK(info.events.width == 0);
    CHECK(info.events.last_s == doctest::Approx(0.7));
    CHECK(says(info, {"1 malformed"}));
  }

  TEST_CASE("many faults of a kind are named up to a limit and then counted") {
    const TemporaryFolder folder;
    std::string text = imu_lines(0, 10);
    for (int i = 0; i < 50; ++i) text += "fault\n";
    write_file(folder / "imu.txt", text);
    const RecordingInfo info = survey_of(folder.path());
    CHECK(info.problems.size() == kMaxProblemsOfAKind + 1);
    CHECK(says(info, {"45 more unreadable lines"}));
  }

  TEST_CASE("progress rises from 0 to 1") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", imu_lines(0, 5000));
    Problems problems;
    const auto recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    std::vector<double> values;
    REQUIRE(
        survey(recording.value(), problems, [&](double value) { values.push_back(value); }).ok());
    REQUIRE(values.size() > 2);
    CHECK(values.front() >= 0.0);
    CHECK(values.back() == 1.0);
    CHECK(std::is_sorted(values.begin(), values.end()));
  }
}
