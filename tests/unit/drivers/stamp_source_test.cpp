#include "drivers/replay/stamp_source.hpp"

#include <doctest/doctest.h>

using namespace pled;
using namespace pled::replay;

TEST_SUITE("drivers.stamp_source") {
  TEST_CASE(
      "regular stamps run from the first to the last, both included, without adding up error") {
    using Stamps = std::vector<std::int64_t>;
    CHECK(StampSource::regular(1'000, 1'000, 20) == Stamps{1'000});
    CHECK(StampSource::regular(0, 100'000'000, 20) == Stamps{0, 50'000'000, 100'000'000});
    CHECK(StampSource::regular(-70'000'000, 29'999'999, 20) == Stamps{-70'000'000, -20'000'000});
    CHECK(StampSource::regular(5, 4, 20).empty());
    const Stamps thirds =
        StampSource::regular(1'600'000'000'000'000'000, 1'600'000'100'000'000'000, 30);
    REQUIRE(thirds.size() == 3001);
    CHECK(thirds[1] - thirds[0] == 33'333'333);
    CHECK(thirds[2999] - thirds[0] == 99'966'666'667);
    CHECK(thirds[3000] - thirds[0] == 100'000'000'000);
  }

  TEST_CASE("frames have the stamps, rounded to microseconds beside, and no image") {
    StampSource source({-1'500, -1'499, 0, 1'499, 1'500, 2'000'000'499});
    REQUIRE(source.start().ok());
    for (const auto& [stamp_ns, t_us] :
         std::vector<std::pair<std::int64_t, std::int64_t>>{{-1'500, -2},
                                                            {-1'499, -1},
                                                            {0, 0},
                                                            {1'499, 1},
                                                            {1'500, 2},
                                                            {2'000'000'499, 2'000'000}}) {
      const auto frame = source.acquire(Duration{});
      REQUIRE(frame.ok());
      CHECK(frame.value().stamp_ns == stamp_ns);
      CHECK(frame.value().t.us == t_us);
      CHECK(frame.value().image.empty());
      source.release();
    }
    for (int again = 0; again < 2; ++again) {
      const auto end = source.acquire(Duration{});
      REQUIRE_FALSE(end.ok());
      CHECK(end.error().code == ErrorCode::kEndOfStream);
    }
    source.stop();
  }
}
