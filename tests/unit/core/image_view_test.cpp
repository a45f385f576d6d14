#include "pled_vins/core/image_view.hpp"

#include <array>
#include <cstdint>
#include <type_traits>

#include <doctest/doctest.h>

namespace pled {
namespace {

static_assert(!std::is_convertible_v<ImageView<const int>, ImageView<int>>);

TEST_SUITE("core.image_view") {
  TEST_CASE("a pixel is found at row times stride plus column") {
    // Two rows of three pixels, each followed by one value of padding.
    std::array<std::uint8_t, 8> pixels{10, 11, 12, 99, 20, 21, 22, 99};
    const ImageView<std::uint8_t> view{pixels.data(), 3, 2, 4};
    CHECK(view.at(0, 2) == 12);
    CHECK(view.at(1, 0) == 20);
    CHECK(view.at(1, 2) == 22);
    CHECK(view.row(1) == pixels.data() + 4);
  }

  TEST_CASE("writing through a view changes the owner's pixel") {
    std::array<std::uint8_t, 4> pixels{};
    const ImageView<std::uint8_t> view{pixels.data(), 2, 2, 2};
    view.at(1, 0) = 7;
    CHECK(pixels[2] == 7);
  }

  TEST_CASE("a read-only view sees the same pixels") {
    std::array<int, 4> pixels{1, 2, 3, 4};
    const ImageView<int> view{pixels.data(), 2, 2, 2};
    const ImageView<const int> read_only = view;
    CHECK(&read_only.at(1, 1) == &pixels[3]);
    CHECK(read_only.width == 2);
    CHECK(read_only.height == 2);
    CHECK(read_only.stride == 2);
  }

  TEST_CASE("only a view without pixels is empty") {
    int pixel = 0;
    CHECK(ImageView<int>{}.empty());
    CHECK_FALSE(ImageView<int>{&pixel, 1, 1, 1}.empty());
  }

  TEST_CASE("rows may run upwards when the stride is negative") {
    std::array<int, 4> pixels{1, 2, 3, 4};
    const ImageView<int> view{pixels.data() + 2, 2, 2, -2};
    CHECK(view.at(0, 0) == 3);
    CHECK(view.at(1, 1) == 2);
  }
}

}  // namespace
}  // namespace pled
