#include "drivers/replay/raw_file_source.hpp"

#include <doctest/doctest.h>

#include "drivers/replay/raw_header.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

RawHeader header_of(const std::string& text) {
  const auto header = parse_raw_header(std::as_bytes(std::span{text}));
  REQUIRE(header.ok());
  return header.value();
}

/// Everything the source gives, and how many chunks it took.
std::string read_all(RawFileSource& source, std::size_t& chunks) {
  std::string text;
  chunks = 0;
  while (true) {
    const auto chunk = source.acquire(Duration{});
    if (!chunk.ok()) {
      CHECK(chunk.error().code == ErrorCode::kEndOfStream);
      return text;
    }
    ++chunks;
    text.append(reinterpret_cast<const char*>(chunk.value().bytes.data()),
                chunk.value().bytes.size());
    source.release();
  }
}

}  // namespace

TEST_SUITE("drivers.raw_header") {
  TEST_CASE("the format line gives the format and the size") {
    const std::string text = "% format EVT3;height=720;width=1280\n% end\n";
    const RawHeader header = header_of(text + "% x\n");
    CHECK(header.format == RawFormat::kEvt3);
    CHECK(header.width_px == 1280);
    CHECK(header.height_px == 720);
    CHECK(header.bytes == text.size());
  }

  TEST_CASE("older headers say evt and geometry, and end with the first line that is none") {
    const std::string text = "% Date 2020-09-25 07:48:29\n% evt 3.0\r\n% geometry 640x480\n";
    const RawHeader header = header_of(text + std::string("\x00\x80\n% end\n", 9));
    CHECK(header.format == RawFormat::kEvt3);
    CHECK(header.width_px == 640);
    CHECK(header.height_px == 480);
    CHECK(header.bytes == text.size());
  }

  TEST_CASE("words that look like the beginning of a line are not taken for the header") {
    const std::string text = "% evt 2.0\n";
    const RawHeader header = header_of(text + "% \x01\x80\n");
    CHECK(header.format == RawFormat::kEvt2);
    CHECK(header.bytes == text.size());
    CHECK(header.width_px == 0);
  }

  TEST_CASE("a file without header is all data") {
    CHECK(header_of("0.1 1 2 1\n").bytes == 0);
    CHECK(header_of("").bytes == 0);
    CHECK(header_of("% no line end").bytes == 0);
  }

  TEST_CASE("a size that is no size is an error with its line") {
    for (const char* bad : {"% geometry 640by480\n", "% geometry 0x480\n", "% geometry nanx1\n",
                            "% format EVT3;width=-3\n", "% format EVT3;height=999999\n"}) {
      CAPTURE(bad);
      const std::string text = std::string("% evt 3.0\n") + bad;
      const auto header = parse_raw_header(std::as_bytes(std::span{text}));
      REQUIRE_FALSE(header.ok());
      CHECK(header.error().code == ErrorCode::kCorrupt);
      CHECK(header.error().detail == 2);
    }
  }
}

TEST_SUITE("drivers.raw_file_source") {
  TEST_CASE(
      "the bytes behind the header come in order, in chunks of fixed size, again after start") {
    const TemporaryFolder folder;
    std::string data;
    for (std::size_t i = 0; i < 2 * limits::kChunkBytes + 5; ++i) {
      data.push_back(static_cast<char>(i * 31));
    }
    write_file(folder / "events.raw", "HEAD" + data);
    auto source = RawFileSource::open((folder / "events.raw").c_str(), {4, false});
    REQUIRE(source.ok());
    CHECK(source.value()->acquire(Duration{}).error().code == ErrorCode::kEndOfStream);
    for (int round = 0; round < 2; ++round) {
      REQUIRE(source.value()->start().ok());
      std::size_t chunks = 0;
      CHECK(read_all(*source.value(), chunks) == data);
      CHECK(chunks == 3);
      CHECK(source.value()->position() == source.value()->size());
    }
  }

  TEST_CASE("a text file gets the end of its last line, once") {
    const TemporaryFolder folder;
    std::size_t chunks = 0;
    for (const std::string& text : {std::string("a\nb"), std::string("a\nb\n"), std::string(),
                                    std::string(limits::kChunkBytes, 'x')}) {
      write_file(folder / "events.txt", text);
      auto source = RawFileSource::open((folder / "events.txt").c_str(), {0, true});
      REQUIRE(source.ok());
      REQUIRE(source.value()->start().ok());
      const bool ended = text.empty() || text.back() == '\n';
      CHECK(read_all(*source.value(), chunks) == (ended ? text : text + "\n"));
    }
  }

  TEST_CASE("chunks stay valid until released, and too many held are refused") {
    const TemporaryFolder folder;
    write_file(folder / "e", std::string(limits::kChunkBytes * (limits::kChunkSlots + 1), 'a'));
    auto source = RawFileSource::open((folder / "e").c_str(), {});
    REQUIRE(source.ok());
    REQUIRE(source.value()->start().ok());
    for (std::size_t i = 0; i < limits::kChunkSlots; ++i) {
      REQUIRE(source.value()->acquire(Duration{}).ok());
    }
    CHECK(source.value()->acquire(Duration{}).error().code == ErrorCode::kTimeout);
    source.value()->release();
    CHECK(source.value()->acquire(Duration{}).ok());
  }

  TEST_CASE("a missing file and a folder are told apart") {
    const TemporaryFolder folder;
    CHECK(RawFileSource::open((folder / "none").c_str(), {}).error().code == ErrorCode::kNotFound);
    CHECK(RawFileSource::open(folder.path().c_str(), {}).error().code ==
          ErrorCode::kInvalidArgument);
  }
}
