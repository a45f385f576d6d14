// What editors, interrupted copies and mistaken paths make of a recording: each is said.

#include <algorithm>
#include <string>

#include <sys/stat.h>

#include <doctest/doctest.h>

#include "drivers/replay/recording_info.hpp"
#include "unit/drivers/evt3_words.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

/// Everything that opening and surveying say.
struct Told {
  bool opened = false;
  bool surveyed = false;
  RecordingInfo info;
  std::vector<std::string> words;

  [[nodiscard]] bool says(std::initializer_list<const char*> parts) const {
    return std::any_of(words.begin(), words.end(), [&](const std::string& line) {
      return std::all_of(parts.begin(), parts.end(),
                         [&](const char* part) { return line.find(part) != std::string::npos; });
    });
  }
};

Told told_of(const std::string& path) {
  Told told;
  Problems problems;
  const auto recording = Recording::open(path, problems);
  told.opened = recording.ok();
  if (recording.ok()) {
    const auto info = survey(recording.value(), problems, {});
    told.surveyed = info.ok();
    if (info.ok()) told.info = info.value();
  }
  for (const Problem& problem : problems) told.words.push_back(to_string(problem));
  told.words.insert(told.words.end(), told.info.problems.begin(), told.info.problems.end());
  return told;
}

const std::string kMark = "\xEF\xBB\xBF";
const std::string kHeader = "% evt 3.0\n% geometry 240x180\n% end\n";

std::string raw_file(const Words& words) {
  std::string bytes = kHeader;
  for (const std::byte byte : wire(words)) bytes += static_cast<char>(byte);
  return bytes;
}

/// One image, listed at 20 Hz from 0 to 3 s but for the stamps in (from_s, to_s).
void write_frames(const TemporaryFolder& folder, double from_s, double to_s) {
  write_grey_png(folder / "a.png", 9, 8);
  std::string list;
  for (int i = 0; i <= 60; ++i)
    if (const double t_s = 0.05 * i; t_s <= from_s || t_s >= to_s)
      list += std::to_string(t_s) + " a.png\n";
  write_file(folder / "images.txt", list);
}

}  // namespace

TEST_SUITE("drivers.input_faults") {
  TEST_CASE("a UTF-8 mark before the first line costs no line") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 9, 8);
    write_file(folder / "images.txt", kMark + "0.1 a.png\n0.2 a.png\n");
    write_file(folder / "imu.txt", kMark + "0 0 0 9.81 0 0 0\n0.1 0 0 9.81 0 0 0\n");
    write_file(folder / "events.txt", kMark + "0.1 3 4 1\n0.2 3 4 0\n");
    write_file(folder / "groundtruth.txt", kMark + "0 1 2 3 0 0 0 1\n");
    const Told told = told_of(folder.path());
    REQUIRE(told.surveyed);
    CHECK(told.info.frames.count == 2);
    CHECK(told.info.imu.count == 2);
    CHECK(told.info.events.count == 2);
    CHECK(told.info.truth.count == 1);
    CHECK_FALSE(told.says({"line 1"}));
  }

  TEST_CASE("a pipe among the images is one frame lost, not a wait for ever") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 9, 8);
    REQUIRE(::mkfifo((folder / "pipe.png").c_str(), 0600) == 0);
    write_file(folder / "images.txt", std::string("0.1 a.png\n0.2 pipe.png\n0.3 a.png\n"));
    const Told told = told_of(folder.path());
    REQUIRE(told.surveyed);
    CHECK(told.info.frames.count == 2);
    CHECK(told.says({"pipe.png", "no regular file"}));
  }

  TEST_CASE("folders in the place of files are told as such") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", std::string("0 0 0 9.81 0 0 0\n"));
    for (const char* name : {"events.raw", "groundtruth.txt", "images.txt"})
      std::filesystem::create_directory(folder / name);
    const Told told = told_of(folder.path());
    REQUIRE(told.surveyed);
    for (const char* name : {"events.raw", "groundtruth.txt", "images.txt"})
      CHECK(told.says({name, "is a folder"}));
  }

  TEST_CASE("files of other formats are refused by name, as events and as a file alone") {
    const TemporaryFolder folder;
    write_grey_png(folder / "picture.png", 9, 8);
    write_file(folder / "cars.dat",
               std::string("% Data file containing Event2D events.\n% Version 2\n12345678"));
    for (const char* name : {"picture.png", "cars.dat"}) {
      CAPTURE(name);
      const Told told = told_of(folder / name);
      CHECK_FALSE(told.opened);
      CHECK(told.says({"error", name, "not an event file that can be read"}));
    }
    write_file(folder / "events.raw", std::string("PK\x03\x04 and more"));
    CHECK(told_of(folder.path()).says({"events.raw", "zip"}));
  }

  TEST_CASE("a file whose lines or words are mostly malformed holds no events") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", std::string("0 0 0 9.81 0 0 0\n0.1 0 0 9.81 0 0 0\n"));
    const Told text = told_of(folder / "imu.txt");
    CHECK_FALSE(text.surveyed);
    CHECK(text.says({"error", "not an event file", "2 of 2 lines"}));
    // A linear congruential generator: Numerical Recipes, chapter 7.1.
    std::string noise = kHeader;
    std::uint32_t state = 1;
    for (int i = 0; i < 20000; ++i) {
      state = state * 1664525U + 1013904223U;
      noise += static_cast<char>(state >> 24);
    }
    write_file(folder / "noise.raw", noise);
    const Told raw = told_of(folder / "noise.raw");
    CHECK_FALSE(raw.surveyed);
    CHECK(raw.says({"error", "not an event file", "of 10000 words"}));
  }

  TEST_CASE("events that were cut in a word or end with their header are told") {
    const TemporaryFolder folder;
    const Words words{time_high(1), addr_y(9), cd(3, Polarity::kOn)};
    write_file(folder / "events.raw", raw_file(words) + "x");
    CHECK(told_of(folder.path()).says({"events.raw", "middle of a word"}));
    write_file(folder / "events.raw", raw_file({}));
    const Told empty = told_of(folder.path());
    REQUIRE(empty.surveyed);
    CHECK(empty.says({"events.raw", "a header and not one event"}));
    write_file(folder / "events.raw", raw_file(words));
    CHECK(told_of(folder.path()).words.empty());
  }

  TEST_CASE("a stream that ends long before the frames, and a camera that drops out, are told") {
    const TemporaryFolder folder;
    write_frames(folder, 1.0, 2.0);
    write_file(folder / "events.txt", std::string("0.0 3 4 1\n1.1 3 4 1\n1.1 4 4 1\n"));
    write_file(folder / "imu.txt", std::string("0.7 0 0 9.81 0 0 0\n3 0 0 9.81 0 0 0\n"));
    const Told told = told_of(folder.path());
    REQUIRE(told.surveyed);
    CHECK(told.info.frames.gaps == 1);
    CHECK(told.info.frames.longest_gap_s == doctest::Approx(1.0));
    CHECK(told.says({"images.txt", "no frame for 1.000000 s before t = 2.000000 s"}));
    CHECK(told.says({"events.txt", "ends at 1.100000 s, 1.900 s before the last frame"}));
    CHECK(told.says({"imu.txt", "begins at 0.700000 s, 0.700 s after the first frame"}));
    const TemporaryFolder whole;
    write_frames(whole, 1.0, 1.2);  // three frames lost are no drop-out
    CHECK(told_of(whole.path()).info.frames.gaps == 0);
  }

  TEST_CASE("label images are looked at, not only their list") {
    const TemporaryFolder folder;
    write_frames(folder, 3.0, 3.0);
    write_grey_png(folder / "m.png", 9, 8);
    write_file(folder / "masks.txt", std::string("0 m.png\n0.05 none.png\n0.1 m.png\n"));
    Told told = told_of(folder.path());
    CHECK(told.info.masks.count == 2);
    CHECK(told.says({"none.png", "masks.txt line 2"}));
    write_file(folder / "masks.txt", std::string("0 none.png\n"));
    told = told_of(folder.path());
    REQUIRE(told.surveyed);
    CHECK(told.info.masks.present);
    CHECK(told.info.masks.count == 0);
    CHECK(told.says({"masks.txt", "none of the label images"}));
  }
}
