#include "pled_vins/core/fixed_vector.hpp"

#include <algorithm>
#include <initializer_list>
#include <type_traits>

#include <doctest/doctest.h>

namespace pled {
namespace {

FixedVector<int, 4> vector_of(std::initializer_list<int> values) {
  FixedVector<int, 4> v;
  for (const int value : values) REQUIRE(v.push_back(value));
  return v;
}

bool holds(const FixedVector<int, 4>& v, std::initializer_list<int> values) {
  return std::equal(v.begin(), v.end(), values.begin(), values.end());
}

static_assert(std::is_trivially_copyable_v<FixedVector<int, 4>>);
static_assert(FixedVector<int, 4>::capacity() == 4);

TEST_SUITE("core.fixed_vector") {
  TEST_CASE("a new vector is empty and holds items in the order of arrival") {
    CHECK(FixedVector<int, 4>{}.empty());
    const FixedVector<int, 4> v = vector_of({7, 8, 9});
    CHECK(v.size() == 3);
    CHECK(v.front() == 7);
    CHECK(v.back() == 9);
    CHECK(v[1] == 8);
  }

  TEST_CASE("a full vector refuses the newest item and keeps the others") {
    FixedVector<int, 4> v = vector_of({1, 2, 3, 4});
    CHECK(v.full());
    CHECK_FALSE(v.push_back(5));
    CHECK(holds(v, {1, 2, 3, 4}));
  }

  TEST_CASE("erasing an item closes the gap and keeps the order") {
    FixedVector<int, 4> v = vector_of({1, 2, 3, 4});
    v.erase(1);
    CHECK(holds(v, {1, 3, 4}));
    v.erase(2);
    CHECK(holds(v, {1, 3}));
    v.erase(0);
    CHECK(holds(v, {3}));
  }

  TEST_CASE("growing gives zeros even where an item stood before") {
    FixedVector<int, 4> v = vector_of({1, 2, 3});
    v.pop_back();
    v.pop_back();
    REQUIRE(v.resize(4));
    CHECK(holds(v, {1, 0, 0, 0}));
  }

  TEST_CASE("resizing past the capacity is refused and changes nothing") {
    FixedVector<int, 4> v = vector_of({1, 2});
    CHECK_FALSE(v.resize(5));
    CHECK(holds(v, {1, 2}));
  }

  TEST_CASE("a span covers the items and not the spare room") {
    FixedVector<int, 4> v = vector_of({1, 2});
    CHECK(v.span().size() == 2);
    CHECK(v.span().data() == v.data());
    v.clear();
    CHECK(v.span().empty());
  }

  TEST_CASE("a copy is independent of its original") {
    FixedVector<int, 4> v = vector_of({1, 2});
    const FixedVector<int, 4> copy = v;
    v[0] = 9;
    REQUIRE(v.push_back(3));
    CHECK(holds(copy, {1, 2}));
  }
}

}  // namespace
}  // namespace pled
