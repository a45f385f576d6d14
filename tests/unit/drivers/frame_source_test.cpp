#include "drivers/replay/frame_source.hpp"

#include <doctest/doctest.h>

#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

constexpr ImageSize kMax{64, 48};

std::unique_ptr<FrameFileSource> open_frames(const TemporaryFolder& folder, const std::string& list,
                                             FrameListFormat format = FrameListFormat::kRpg,
                                             std::size_t slots = 1) {
  write_file(folder / "images.txt", list);
  auto source = FrameFileSource::open({folder / "images.txt", folder.path(), format, kMax, slots});
  REQUIRE(source.ok());
  REQUIRE(source.value()->start().ok());
  return std::move(source).value();
}

/// Stamps of all readable frames; the faults are skipped.
std::vector<std::int64_t> stamps(FrameFileSource& source) {
  std::vector<std::int64_t> all;
  while (true) {
    const auto frame = source.acquire(Duration{});
    if (frame.ok()) {
      all.push_back(frame.value().stamp_ns);
      source.release();
    } else if (frame.error().code == ErrorCode::kEndOfStream) {
      return all;
    }
  }
}

}  // namespace

TEST_SUITE("drivers.frame_source") {
  TEST_CASE("the stamp is kept to the nanosecond and rounded to the microsecond") {
    const TemporaryFolder folder;
    write_grey_png(folder / "images/a.png", 5, 4);
    auto source = open_frames(folder, "1403715273.262143535 images/a.png\n");
    const auto frame = source->acquire(Duration{});
    REQUIRE(frame.ok());
    CHECK(frame.value().stamp_ns == 1403715273262143535);
    CHECK(frame.value().t.us == 1403715273262144);
    CHECK(frame.value().image.width == 5);
    CHECK(frame.value().image.height == 4);
    CHECK(frame.value().image.at(2, 3) == pattern(5, 4)[2 * 5 + 3]);
  }

  TEST_CASE("a EuRoC list has integer stamps, commas and a heading") {
    const TemporaryFolder folder;
    write_grey_png(folder / "1.png", 5, 4);
    auto source = open_frames(folder, "#timestamp [ns],filename\r\n1403715273262142976,1.png\r\n",
                              FrameListFormat::kEuroc);
    const auto frame = source->acquire(Duration{});
    REQUIRE(frame.ok());
    CHECK(frame.value().stamp_ns == 1403715273262142976);
  }

  TEST_CASE("a frame whose stamp is not later than the last is skipped and counted") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 5, 4);
    auto source = open_frames(folder, "1 a.png\n2 a.png\n2 a.png\n1.5 a.png\n0 a.png\n3 a.png\n");
    CHECK(stamps(*source) ==
          std::vector<std::int64_t>{1'000'000'000, 2'000'000'000, 3'000'000'000});
    CHECK(source->faults().out_of_order == 3);
    CHECK(source->last_message().find("line 5") != std::string_view::npos);
  }

  TEST_CASE("a stamp that leaps ahead costs its own line, at the beginning and at the end too") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 5, 4);
    auto source = open_frames(
        folder, "900 a.png\n1 a.png\n2 a.png\n800 a.png\n3 a.png\nno line\n4 a.png\n700 a.png\n");
    // Nothing follows the last one that could tell it from a pause.
    CHECK(stamps(*source) == std::vector<std::int64_t>{1'000'000'000, 2'000'000'000, 3'000'000'000,
                                                       4'000'000'000, 700'000'000'000});
    CHECK(source->faults().out_of_order == 2);
    CHECK(source->faults().malformed_lines == 1);
  }

  TEST_CASE("each damaged frame is lost alone, with its name and reason") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 5, 4);
    write_grey_png(folder / "cut.png", 5, 4);
    truncate_file(folder / "cut.png", 0.7);
    write_jpeg(folder / "cut.jpg", 5, 4, pattern(5, 4));
    truncate_file(folder / "cut.jpg", 0.7);
    write_grey_png(folder / "small.png", 4, 4);
    write_grey_png(folder / "large.png", 65, 4);
    write_file(folder / "empty.png", std::string());
    auto source =
        open_frames(folder,
                    "1 a.png\n2 cut.png\n3 cut.jpg\n4 small.png\n5 large.png\n6 empty.png\n"
                    "7 none.png\nnan a.png\nword\n8 a.png b.png\n9 a.png\n");
    CHECK(source->acquire(Duration{}).ok());
    source->release();
    struct Expected {
      ErrorCode code;
      const char* words;
    };
    for (const Expected& expected :
         {Expected{ErrorCode::kTruncated, "cut.png"}, Expected{ErrorCode::kTruncated, "cut.jpg"},
          Expected{ErrorCode::kCorrupt, "small.png"}, Expected{ErrorCode::kCorrupt, "large.png"},
          Expected{ErrorCode::kTruncated, "empty.png"}, Expected{ErrorCode::kCorrupt, "none.png"},
          Expected{ErrorCode::kCorrupt, "line 8"}, Expected{ErrorCode::kCorrupt, "line 9"},
          Expected{ErrorCode::kCorrupt, "line 10"}}) {
      CAPTURE(expected.words);
      const auto lost = source->acquire(Duration{});
      REQUIRE_FALSE(lost.ok());
      CHECK(lost.error().code == expected.code);
      CHECK(source->last_message().find(expected.words) != std::string_view::npos);
    }
    CHECK(source->acquire(Duration{}).ok());
    CHECK(source->faults().unreadable == 6);
    CHECK(source->faults().malformed_lines == 3);
  }

  TEST_CASE("held frames keep their pixels; one more than the slots is refused until a release") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 5, 4);
    write_png(folder / "b.png", 5, 4, std::vector<std::uint8_t>(20, 9));
    auto source = open_frames(folder, "1 a.png\n2 b.png\n3 b.png\n", FrameListFormat::kRpg, 2);
    const auto first = source->acquire(Duration{});
    const auto second = source->acquire(Duration{});
    REQUIRE(first.ok());
    REQUIRE(second.ok());
    CHECK(source->acquire(Duration{}).error().code == ErrorCode::kTimeout);
    CHECK(first.value().image.at(0, 1) == pattern(5, 4)[1]);
    CHECK(second.value().image.at(0, 1) == 9);
    source->release();
    CHECK(source->acquire(Duration{}).ok());
  }

  TEST_CASE("an empty list is the end at once; a missing list is not found") {
    const TemporaryFolder folder;
    auto source = open_frames(folder, "");
    CHECK(source->acquire(Duration{}).error().code == ErrorCode::kEndOfStream);
    CHECK(
        FrameFileSource::open({folder / "none.txt", folder.path(), FrameListFormat::kRpg, kMax, 1})
            .error()
            .code == ErrorCode::kNotFound);
  }
}
