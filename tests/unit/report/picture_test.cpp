#include "src/report/picture.hpp"

#include <doctest/doctest.h>

#include "src/report/base64.hpp"
#include "src/report/event_pictures.hpp"

namespace {

using namespace pled::report;

TEST_SUITE("report.picture") {
  TEST_CASE("base64 gives the examples of RFC 4648") {
    CHECK(base64("").empty());
    CHECK(base64("f") == "Zg==");
    CHECK(base64("fo") == "Zm8=");
    CHECK(base64("foo") == "Zm9v");
    CHECK(base64("foobar") == "Zm9vYmFy");
    CHECK(base64(std::string("\xff\xfe\x00", 3)) == "//4A");
  }

  TEST_CASE("a picture shrinks to the mean of what it had, and never grows") {
    Picture picture(4, 2);
    picture.pixels = {0, 100, 200, 200, 100, 200, 0, 0};
    const Picture half = shrunk(picture.view(), 2);
    CHECK(half.width_px == 2);
    CHECK(half.height_px == 1);
    CHECK(half.pixels == std::vector<std::uint8_t>{100, 100});
    CHECK(shrunk(picture.view(), 100).pixels == picture.pixels);
    CHECK(thinned(picture.view(), 2).pixels == std::vector<std::uint8_t>{0, 200});
  }

  TEST_CASE("a picture that is too heavy is made coarser and smaller until it fits") {
    Picture noise(320, 240);
    unsigned state = 1;
    for (std::uint8_t& pixel : noise.pixels)
      pixel = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
    const std::string whole = png_base64(noise);
    CHECK(whole.starts_with("iVBORw0KGgo"));  // the signature of a PNG
    CHECK(png_base64_within(noise, 1'000'000) == whole);
    const std::string smaller = png_base64_within(noise, 20'000);
    CHECK(smaller.size() <= 20'000);
    CHECK(smaller.starts_with("iVBORw0KGgo"));
  }

  TEST_CASE("an event picture holds the events of its 30 ms, the last of a pixel on top") {
    using pled::Event;
    using pled::Polarity;
    EventPictures pictures({100'000, 110'000}, {10, 5}, 640);
    const std::vector<Event> events{{{70'000}, 0, 0, Polarity::kOn},    // too early for both
                                    {{70'001}, 1, 0, Polarity::kOn},    // the first alone
                                    {{90'000}, 2, 0, Polarity::kOn},    // both
                                    {{100'000}, 2, 0, Polarity::kOff},  // both
                                    {{105'000}, 3, 4, Polarity::kOn},   // the second alone
                                    {{110'001}, 4, 0, Polarity::kOn}};  // too late
    pictures.add(events);
    CHECK(pictures.count(0) == 3);
    CHECK(pictures.count(1) == 3);
    Picture first = pictures.picture(0);
    CHECK(first.at(0, 0) == EventPictures::kNone);
    CHECK(first.at(0, 1) == EventPictures::kOn);
    CHECK(first.at(0, 2) == EventPictures::kOff);
    Picture second = pictures.picture(1);
    CHECK(second.at(4, 3) == EventPictures::kOn);
    CHECK(second.at(0, 4) == EventPictures::kNone);
  }
}

}  // namespace
