#include "drivers/replay/recording.hpp"

#include <algorithm>

#include <doctest/doctest.h>

#include "unit/drivers/evt3_words.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

/// True when one problem's words hold all of the parts.
bool says(const Problems& problems, std::initializer_list<const char*> parts) {
  return std::any_of(problems.begin(), problems.end(), [&](const Problem& problem) {
    const std::string words = to_string(problem);
    return std::all_of(parts.begin(), parts.end(),
                       [&](const char* part) { return words.find(part) != std::string::npos; });
  });
}

void write_raw(const std::string& path, const std::string& header, const Words& words) {
  std::vector<std::byte> bytes;
  for (const char c : header) bytes.push_back(static_cast<std::byte>(c));
  const auto body = wire(words);
  bytes.insert(bytes.end(), body.begin(), body.end());
  write_file(path, bytes);
}

}  // namespace

TEST_SUITE("drivers.recording") {
  TEST_CASE("an RPG folder has its streams, sizes and sources") {
    const TemporaryFolder folder;
    write_grey_png(folder / "images/a.png", 20, 10);
    write_grey_png(folder / "masks/a.png", 20, 10);
    write_file(folder / "images.txt", std::string("0.5 images/a.png\n"));
    write_file(folder / "masks.txt", std::string("0.5 masks/a.png\n"));
    write_file(folder / "imu.txt", std::string("0 1 2 3 4 5 6\n"));
    write_file(folder / "groundtruth.txt", std::string("0 1 2 3 0 0 0 1\n"));
    write_file(folder / "camchain.yaml", std::string("cam0:\n"));
    write_raw(folder / "events.raw", "% format EVT3;height=180;width=240\n% end\n",
              {time_high(1), addr_y(179), cd(239, Polarity::kOn)});
    Problems problems;
    const auto opened = Recording::open(folder.path(), problems);
    REQUIRE(opened.ok());
    CHECK(problems.empty());
    const Recording& recording = opened.value();
    CHECK(recording.layout() == Layout::kRpg);
    for (const Stream stream :
         {Stream::kEvents, Stream::kImu, Stream::kFrames, Stream::kTruth, Stream::kMasks}) {
      CHECK(recording.has(stream));
    }
    CHECK(recording.event_size() == ImageSize{240, 180});
    CHECK(recording.frame_size() == ImageSize{20, 10});
    CHECK(recording.files().camchain == folder / "camchain.yaml");
    CHECK(recording.files().imu_yaml.empty());

    auto frames = recording.open_frames(2, problems);
    REQUIRE(frames.ok());
    CHECK(frames.value()->acquire(Duration{}).ok());
    auto masks = recording.open_masks(1, problems);
    REQUIRE(masks.ok());
    CHECK(masks.value()->acquire(Duration{}).ok());
    auto imu = recording.open_imu(problems);
    REQUIRE(imu.ok());
    CHECK(imu.value()->read(Duration{}).ok());
    auto truth = recording.open_truth(problems);
    REQUIRE(truth.ok());
    CHECK(truth.value().next().ok());
    auto events = recording.open_events(problems);
    REQUIRE(events.ok());
    REQUIRE(events.value().source->start().ok());
    const auto chunk = events.value().source->acquire(Duration{});
    REQUIRE(chunk.ok());
    CHECK(decode_all(*events.value().decoder, chunk.value().bytes).size() == 1);
  }

  TEST_CASE("a EuRoC folder is found from its parent and from within") {
    const TemporaryFolder folder;
    write_file(folder / "mav0/imu0/data.csv", std::string("#t\n1000,1,2,3,4,5,6\n"));
    write_file(folder / "mav0/cam0/data.csv", std::string("#t\n1000,7.png\n"));
    write_grey_png(folder / "mav0/cam0/data/7.png", 30, 20);
    write_file(folder / "mav0/gt0/data.csv", std::string("#t\n1000,1,2,3,1,0,0,0\n"));
    for (const std::string& path : {folder.path(), folder / "mav0"}) {
      CAPTURE(path);
      Problems problems;
      const auto recording = Recording::open(path, problems);
      REQUIRE(recording.ok());
      CHECK(problems.empty());
      CHECK(recording.value().layout() == Layout::kEuroc);
      CHECK(recording.value().frame_size() == ImageSize{30, 20});
      auto frames = recording.value().open_frames(1, problems);
      REQUIRE(frames.ok());
      CHECK(frames.value()->acquire(Duration{}).ok());
      auto imu = recording.value().open_imu(problems);
      REQUIRE(imu.ok());
      const auto sample = imu.value()->read(Duration{});
      REQUIRE(sample.ok());
      CHECK(sample.value().gyro_radps[0] == 1.0);
      auto truth = recording.value().open_truth(problems);
      REQUIRE(truth.ok());
      CHECK(truth.value().next().ok());
      CHECK_FALSE(recording.value().has(Stream::kEvents));
    }
  }

  TEST_CASE("an empty folder is an error that lists what was looked for") {
    const TemporaryFolder folder;
    Problems problems;
    const auto recording = Recording::open(folder.path(), problems);
    REQUIRE_FALSE(recording.ok());
    CHECK(recording.error().code == ErrorCode::kNotFound);
    CHECK(says(problems, {"error", folder.path().c_str(), "events.raw", "events.txt", "images.txt",
                          "imu.txt", "mav0"}));
  }

  TEST_CASE("a path that does not exist is an error that names it") {
    const TemporaryFolder folder;
    Problems problems;
    CHECK(Recording::open(folder / "none", problems).error().code == ErrorCode::kNotFound);
    CHECK(says(problems, {"error", "/none", "no such"}));
  }

  TEST_CASE("empty files are missing files, and requiring them says what is needed") {
    const TemporaryFolder folder;
    write_file(folder / "imu.txt", std::string());
    write_file(folder / "events.raw", std::string());
    write_grey_png(folder / "a.png", 4, 4);
    write_file(folder / "images.txt", std::string("1 a.png\n"));
    Problems problems;
    const auto recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    CHECK(says(problems, {"warning", "imu.txt", "empty"}));
    CHECK(says(problems, {"warning", "events.raw", "empty"}));
    CHECK_FALSE(recording.value().has(Stream::kImu));
    problems.clear();
    CHECK(recording.value().require(Stream::kFrames, problems).ok());
    CHECK(problems.empty());
    CHECK_FALSE(recording.value().require(Stream::kImu, problems).ok());
    CHECK(says(problems, {"error", "imu.txt"}));
    CHECK(recording.value().open_imu(problems).error().code == ErrorCode::kNotFound);
    CHECK(recording.value().open_events(problems).error().code == ErrorCode::kNotFound);
  }

  TEST_CASE("damaged first images are passed over to learn the size") {
    const TemporaryFolder folder;
    write_grey_png(folder / "cut.png", 9, 8);
    truncate_file(folder / "cut.png", 0.5);
    write_grey_png(folder / "a.png", 9, 8);
    write_file(folder / "images.txt", std::string("1 cut.png\n2 none.png\n3 a.png\n"));
    Problems problems;
    const auto recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().frame_size() == ImageSize{9, 8});
  }

  TEST_CASE("a list without a single readable image counts as no frames, with a warning") {
    const TemporaryFolder folder;
    write_file(folder / "images.txt", std::string("1 none.png\n"));
    write_file(folder / "imu.txt", std::string("0 1 2 3 4 5 6\n"));
    Problems problems;
    const auto recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    CHECK_FALSE(recording.value().has(Stream::kFrames));
    CHECK(says(problems, {"warning", "images.txt", "none of the images"}));
  }

  TEST_CASE("any number of first images may be missing or of another size") {
    const TemporaryFolder folder;
    std::string list;
    for (int i = 0; i < 30; ++i) list += std::to_string(i) + " none.png\n";
    write_grey_png(folder / "large.png", 12, 10);
    write_grey_png(folder / "a.png", 9, 8);
    write_file(folder / "images.txt", list + "40 large.png\n41 a.png\n42 large.png\n43 a.png\n");
    Problems problems;
    auto recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().frame_size() == ImageSize{12, 10});
    CHECK_FALSE(recording.value().set_frame_size({10, 12}));
    CHECK(recording.value().frame_size() == ImageSize{12, 10});
    REQUIRE(recording.value().set_frame_size({9, 8}));
    CHECK(recording.value().frame_size() == ImageSize{9, 8});
    auto frames = recording.value().open_frames(4, problems);
    REQUIRE(frames.ok());
    std::vector<double> read_s;
    for (int i = 0; i < 34; ++i)
      if (const auto frame = frames.value()->acquire(Duration{}); frame.ok())
        read_s.push_back(frame.value().t.seconds());
    CHECK(read_s == std::vector<double>{41.0, 43.0});
    CHECK(frames.value()->faults().unreadable == 32);
    CHECK(problems.empty());
  }

  TEST_CASE("text events take the size of the calibration, never that of the frames") {
    const TemporaryFolder folder;
    write_file(folder / "events.txt", std::string("0.1 3 4 1"));
    Problems problems;
    auto recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().event_format() == EventFileFormat::kText);
    CHECK(recording.value().open_events(problems).error().code == ErrorCode::kInvalidArgument);
    CHECK(says(problems, {"events.txt", "how large the sensor is"}));
    recording.value().set_event_size({240, 180});
    CHECK(recording.value().open_events(problems).ok());

    write_grey_png(folder / "a.png", 9, 8);
    write_file(folder / "images.txt", std::string("1 a.png\n"));
    problems.clear();
    recording = Recording::open(folder.path(), problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().event_size() == ImageSize{});  // the frames may be another camera's
  }

  TEST_CASE("an event file that cannot be read is refused with the reason") {
    const TemporaryFolder folder;
    write_raw(folder / "evt2.raw", "% evt 2.0\n", {0});
    Problems problems;
    CHECK(Recording::open(folder / "evt2.raw", problems).error().code == ErrorCode::kUnsupported);
    CHECK(says(problems, {"evt2.raw", "EVT2", "EVT3"}));
    problems.clear();
    write_raw(folder / "size.raw", "% evt 3.0\n% geometry 240\n", {0});
    CHECK_FALSE(Recording::open(folder / "size.raw", problems).ok());
    CHECK(says(problems, {"size.raw:2", "size"}));
    problems.clear();
    write_file(folder / "empty.raw", std::string());
    CHECK_FALSE(Recording::open(folder / "empty.raw", problems).ok());
    CHECK(says(problems, {"error", "empty.raw", "no events"}));
  }

  TEST_CASE("a packed event file is pointed out") {
    const TemporaryFolder folder;
    write_file(folder / "events.raw.xz", std::string("x"));
    write_file(folder / "imu.txt", std::string("0 1 2 3 4 5 6\n"));
    Problems problems;
    REQUIRE(Recording::open(folder.path(), problems).ok());
    CHECK(says(problems, {"warning", "events.raw.xz", "unpack"}));
  }
}
