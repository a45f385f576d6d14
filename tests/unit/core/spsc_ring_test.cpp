#include "pled_vins/core/spsc_ring.hpp"

#include <array>
#include <cstdint>
#include <initializer_list>
#include <thread>

#include <doctest/doctest.h>

namespace pled {
namespace {

/// Wide enough that a torn copy shows: every word holds the same number.
struct Wide {
  std::array<std::uint64_t, 9> words{};
};

Wide wide(std::uint64_t n) {
  Wide item;
  item.words.fill(n);
  return item;
}

bool is_whole(const Wide& item) {
  for (const std::uint64_t word : item.words)
    if (word != item.words[0]) return false;
  return true;
}

TEST_SUITE("core.spsc_ring") {
  TEST_CASE("items leave in the order in which they came") {
    SpscRing<int, 4> ring;
    for (const int item : {3, 1, 2}) REQUIRE(ring.push(item));
    for (const int want : {3, 1, 2}) {
      int got = -1;
      REQUIRE(ring.pop(got));
      CHECK(got == want);
    }
  }

  TEST_CASE("a full ring refuses the newest item and every slot is used") {
    SpscRing<int, 4> ring;
    for (int i = 0; i < 4; ++i) REQUIRE(ring.push(i));
    CHECK(ring.size() == ring.capacity());
    CHECK_FALSE(ring.push(99));
    for (int want = 0; want < 4; ++want) {
      int got = -1;
      REQUIRE(ring.pop(got));
      CHECK(got == want);
    }
  }

  TEST_CASE("an empty ring gives nothing and leaves the output alone") {
    SpscRing<int, 2> ring;
    int out = 77;
    CHECK_FALSE(ring.pop(out));
    CHECK(out == 77);
    CHECK(ring.peek() == nullptr);
    CHECK(ring.size() == 0);
  }

  TEST_CASE("peeking shows the oldest item and takes nothing") {
    SpscRing<int, 4> ring;
    REQUIRE(ring.push(5));
    REQUIRE(ring.push(6));
    REQUIRE(ring.peek() != nullptr);
    CHECK(*ring.peek() == 5);
    CHECK(ring.size() == 2);
    int out = -1;
    REQUIRE(ring.pop(out));
    CHECK(out == 5);
    CHECK(*ring.peek() == 6);
  }

  TEST_CASE("the order holds over many laps at every fill") {
    SpscRing<std::uint32_t, 8> ring;
    std::uint32_t pushed = 0;
    std::uint32_t popped = 0;
    for (std::uint32_t lap = 0; lap < 1000; ++lap) {
      const std::uint32_t burst = 1 + lap % 8;
      for (std::uint32_t i = 0; i < burst; ++i)
        if (ring.push(pushed)) ++pushed;
      for (std::uint32_t i = 0; i < 1 + lap % 5; ++i) {
        std::uint32_t got = 0;
        if (!ring.pop(got)) break;
        REQUIRE(got == popped);
        ++popped;
      }
      REQUIRE(ring.size() == pushed - popped);
    }
    CHECK(popped > 1000);
  }

  TEST_CASE("between two threads every item arrives once, whole and in order") {
    constexpr std::uint64_t kItems = 30'000;
    SpscRing<Wide, 16> ring;
    std::uint64_t refused = 0;
    std::thread writer{[&] {
      for (std::uint64_t n = 0; n < kItems; ++n) {
        while (!ring.push(wide(n))) {
          ++refused;
          std::this_thread::yield();
        }
      }
    }};
    std::uint64_t torn = 0;
    std::uint64_t out_of_order = 0;
    for (std::uint64_t want = 0; want < kItems; ++want) {
      Wide got;
      while (!ring.pop(got)) std::this_thread::yield();
      if (!is_whole(got)) ++torn;
      if (got.words[0] != want) ++out_of_order;
    }
    writer.join();
    CHECK(torn == 0);
    CHECK(out_of_order == 0);
    CHECK(ring.size() == 0);
    MESSAGE("the writer met a full ring " << refused << " times");
  }
}

}  // namespace
}  // namespace pled
