#include "drivers/replay/image_reader.hpp"

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 23;
constexpr ImageSize kSize{kWidth, kHeight};
constexpr std::uint8_t kPoison = 0xA5;

/// A reader with memory of its own, for images up to 64 x 48.
struct Reading {
  ImageReader reader{{64, 48}};
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(64 * 48, kPoison);

  Result<ImageSize> read(const std::string& path) { return reader.read(path.c_str(), pixels); }
  [[nodiscard]] std::vector<std::uint8_t> image() const {
    return {pixels.begin(), pixels.begin() + kWidth * kHeight};
  }
};

}  // namespace

TEST_SUITE("drivers.image_reader") {
  TEST_CASE("an 8-bit grey PNG is read to the pixel, and nothing behind it is touched") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", kWidth, kHeight);
    Reading reading;
    const auto size = reading.read(folder / "a.png");
    REQUIRE(size.ok());
    CHECK(size.value() == kSize);
    CHECK(reading.image() == pattern(kWidth, kHeight));
    CHECK(std::all_of(reading.pixels.begin() + kWidth * kHeight, reading.pixels.end(),
                      [](std::uint8_t value) { return value == kPoison; }));
  }

  TEST_CASE("an interlaced grey PNG gives the same pixels") {
    const TemporaryFolder folder;
    write_png(folder / "a.png", kWidth, kHeight, pattern(kWidth, kHeight),
              {.interlace = PNG_INTERLACE_ADAM7});
    Reading reading;
    REQUIRE(reading.read(folder / "a.png").ok());
    CHECK(reading.image() == pattern(kWidth, kHeight));
  }

  TEST_CASE("a colour PNG becomes its BT.601 luma, alpha is ignored") {
    const TemporaryFolder folder;
    for (const int samples : {3, 4}) {
      CAPTURE(samples);
      const auto colours = pattern(kWidth, kHeight, samples);
      write_png(folder / "a.png", kWidth, kHeight, colours,
                {.colour = samples == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA});
      Reading reading;
      REQUIRE(reading.read(folder / "a.png").ok());
      for (std::size_t i = 0; i < kWidth * kHeight; ++i) {
        const std::uint8_t* const rgb = &colours[i * static_cast<std::size_t>(samples)];
        const double expected = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
        REQUIRE(std::abs(reading.pixels[i] - expected) <= 0.51);
      }
    }
  }

  TEST_CASE("a palette is looked up") {
    const TemporaryFolder folder;
    const auto indices = pattern(kWidth, kHeight);
    write_png(folder / "a.png", kWidth, kHeight, indices, {.colour = PNG_COLOR_TYPE_PALETTE});
    Reading reading;
    REQUIRE(reading.read(folder / "a.png").ok());
    for (std::size_t i = 0; i < indices.size(); ++i) {
      REQUIRE(reading.pixels[i] == 255 - indices[i]);  // the writer's palette
    }
  }

  TEST_CASE("16 bits are scaled to 8, 1 bit is spread to 0 and 255") {
    const TemporaryFolder folder;
    write_png(folder / "a.png", 2, 1, {0xFF, 0xFF, 0x80, 0x00}, {.bits = 16});
    Reading reading;
    REQUIRE(reading.read(folder / "a.png").ok());
    CHECK(reading.pixels[0] == 255);
    CHECK(reading.pixels[1] == 128);  // 0x8000 * 255 / 65535 = 127.502, rounded
    write_png(folder / "b.png", 8, 1, {0x81}, {.bits = 1});
    REQUIRE(reading.read(folder / "b.png").ok());
    CHECK(reading.pixels[0] == 255);
    CHECK(reading.pixels[1] == 0);
    CHECK(reading.pixels[7] == 255);
  }

  TEST_CASE("a JPEG of quality 100 is within a few grey levels, in grey and in colour") {
    const TemporaryFolder folder;
    std::vector<std::uint8_t> grey;
    std::vector<std::uint8_t> colour;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const auto value = static_cast<std::uint8_t>(40 + (i % kWidth) * 4 + i / kWidth);
      grey.push_back(value);
      colour.insert(colour.end(), {value, value, value});
    }
    for (const int samples : {1, 3}) {
      CAPTURE(samples);
      write_jpeg(folder / "a.jpg", kWidth, kHeight, samples == 1 ? grey : colour, samples);
      Reading reading;
      const auto size = reading.read(folder / "a.jpg");
      REQUIRE(size.ok());
      CHECK(size.value() == kSize);
      for (std::size_t i = 0; i < grey.size(); ++i) {
        REQUIRE(std::abs(reading.pixels[i] - grey[i]) <= 3);
      }
    }
  }

  TEST_CASE("a truncated image says so, wherever it is cut, and the next image is read") {
    const TemporaryFolder folder;
    Reading reading;
    for (const std::string name : {"a.png", "a.jpg"}) {
      for (const double part : {0.02, 0.3, 0.6, 0.97}) {
        CAPTURE(name);
        CAPTURE(part);
        if (name == "a.png") {
          write_grey_png(folder / name, kWidth, kHeight);
        } else {
          write_jpeg(folder / name, kWidth, kHeight, pattern(kWidth, kHeight));
        }
        REQUIRE(reading.read(folder / name).ok());
        truncate_file(folder / name, part);
        const auto size = reading.read(folder / name);
        REQUIRE_FALSE(size.ok());
        CHECK(size.error().code == ErrorCode::kTruncated);
        CHECK_FALSE(reading.reader.last_message().empty());
      }
    }
    write_grey_png(folder / "b.png", kWidth, kHeight);
    REQUIRE(reading.read(folder / "b.png").ok());
    CHECK(reading.image() == pattern(kWidth, kHeight));
  }

  TEST_CASE("a PNG with a flipped byte is corrupt") {
    const TemporaryFolder folder;
    Reading reading;
    for (const std::streamoff offset : {1, 20, 60}) {  // signature, header, pixel data
      CAPTURE(offset);
      write_grey_png(folder / "a.png", kWidth, kHeight);
      damage_file(folder / "a.png", offset);
      CHECK(reading.read(folder / "a.png").error().code == ErrorCode::kCorrupt);
    }
  }

  TEST_CASE("larger images than the slots are refused by what they declare") {
    const TemporaryFolder folder;
    Reading reading;
    write_grey_png(folder / "a.png", 65, 10);
    CHECK(reading.read(folder / "a.png").error().code == ErrorCode::kTooLarge);
    CHECK(reading.reader.last_message().find("65x10") != std::string_view::npos);
    write_jpeg(folder / "a.jpg", 10, 49, pattern(10, 49));
    CHECK(reading.read(folder / "a.jpg").error().code == ErrorCode::kTooLarge);
    CHECK(reading.reader.probe((folder / "a.jpg").c_str()).error().code == ErrorCode::kTooLarge);
  }

  TEST_CASE("the header alone tells the size of a file cut behind it") {
    const TemporaryFolder folder;
    Reading reading;
    write_grey_png(folder / "a.png", kWidth, kHeight);
    truncate_file(folder / "a.png", 0.5);
    const auto size = reading.reader.probe((folder / "a.png").c_str());
    REQUIRE(size.ok());
    CHECK(size.value() == kSize);
  }

  TEST_CASE("what is no image is refused in words") {
    const TemporaryFolder folder;
    Reading reading;
    write_file(folder / "text.png", std::string("no image"));
    CHECK(reading.read(folder / "text.png").error().code == ErrorCode::kCorrupt);
    write_file(folder / "empty.png", std::string());
    CHECK(reading.read(folder / "empty.png").error().code == ErrorCode::kTruncated);
    CHECK(reading.read(folder / "none.png").error().code == ErrorCode::kNotFound);
    CHECK(reading.reader.last_message() == "not found");
    write_png(folder / "c.png", kWidth, kHeight, pattern(kWidth, kHeight, 3),
              {.colour = PNG_COLOR_TYPE_RGB, .interlace = PNG_INTERLACE_ADAM7});
    CHECK(reading.read(folder / "c.png").error().code == ErrorCode::kUnsupported);
  }
}
