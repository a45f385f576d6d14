#include "drivers/replay/imu_source.hpp"

#include <doctest/doctest.h>

#include "drivers/replay/truth_reader.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

std::unique_ptr<ImuFileSource> open_imu(const TemporaryFolder& folder, const std::string& text,
                                        ImuFormat format) {
  write_file(folder / "imu.txt", text);
  auto source = ImuFileSource::open(folder / "imu.txt", format);
  REQUIRE(source.ok());
  REQUIRE(source.value()->start().ok());
  return std::move(source).value();
}

}  // namespace

TEST_SUITE("drivers.imu_source") {
  TEST_CASE("an RPG line is time, specific force, angular rate") {
    const TemporaryFolder folder;
    auto source = open_imu(folder, "1403715273.262143135 1 2 3 4e-1 5 -6\r\n", ImuFormat::kRpg);
    const auto sample = source->read(Duration{});
    REQUIRE(sample.ok());
    CHECK(sample.value().t.us == 1403715273262143);
    CHECK(sample.value().accel_mps2 == std::array<double, 3>{1, 2, 3});
    CHECK(sample.value().gyro_radps == std::array<double, 3>{0.4, 5, -6});
    CHECK(source->read(Duration{}).error().code == ErrorCode::kEndOfStream);
  }

  TEST_CASE("a EuRoC line is time in ns, angular rate, specific force") {
    const TemporaryFolder folder;
    auto source = open_imu(folder, "#timestamp [ns],w,a\n1403715523912140500,1,2,3,4,5,6\n",
                           ImuFormat::kEuroc);
    const auto sample = source->read(Duration{});
    REQUIRE(sample.ok());
    CHECK(sample.value().t.us == 1403715523912141);
    CHECK(sample.value().gyro_radps == std::array<double, 3>{1, 2, 3});
    CHECK(sample.value().accel_mps2 == std::array<double, 3>{4, 5, 6});
  }

  TEST_CASE("a line that does not read is named and skipped, and the next is read") {
    const TemporaryFolder folder;
    for (const char* bad : {"0.1 1 2 nan 4 5 6", "0.1 1 2 three 4 5 6", "0.1 1 2 3 4 5",
                            "0.1 1 2 3 4 5 6 7", "inf 1 2 3 4 5 6", "0.1 1 2 3 4 5 1e999"}) {
      CAPTURE(bad);
      auto source =
          open_imu(folder, std::string("# c\n0.0 0 0 0 0 0 0\n") + bad + "\n0.2 1 2 3 4 5 6\n",
                   ImuFormat::kRpg);
      CHECK(source->read(Duration{}).ok());
      const auto fault = source->read(Duration{});
      REQUIRE_FALSE(fault.ok());
      CHECK(fault.error().code == ErrorCode::kBadNumber);
      CHECK(fault.error().detail == 3);
      CHECK(source->last_message().find("imu.txt line 3") != std::string_view::npos);
      CHECK(source->malformed() == 1);
      const auto next = source->read(Duration{});
      REQUIRE(next.ok());
      CHECK(next.value().t.us == 200000);
    }
  }

  TEST_CASE("stamps are given as they come, also repeated and backwards") {
    const TemporaryFolder folder;
    auto source = open_imu(folder, "2 0 0 0 0 0 0\n2 0 0 0 0 0 0\n1 0 0 0 0 0 0", ImuFormat::kRpg);
    for (const std::int64_t expected_us : {2'000'000, 2'000'000, 1'000'000}) {
      const auto sample = source->read(Duration{});
      REQUIRE(sample.ok());
      CHECK(sample.value().t.us == expected_us);
    }
  }

  TEST_CASE("a line longer than the buffer is a fault of its own, the next line is read") {
    const TemporaryFolder folder;
    auto source =
        open_imu(folder, std::string(3 * LineReader::kBufferBytes, '7') + "\n1 0 0 0 0 0 0\n",
                 ImuFormat::kRpg);
    CHECK(source->read(Duration{}).error().code == ErrorCode::kBadNumber);
    const auto next = source->read(Duration{});
    REQUIRE(next.ok());
    CHECK(next.value().t.us == 1'000'000);
  }

  TEST_CASE("an empty file is the end at once, a missing one is not found") {
    const TemporaryFolder folder;
    auto source = open_imu(folder, "", ImuFormat::kRpg);
    CHECK(source->read(Duration{}).error().code == ErrorCode::kEndOfStream);
    CHECK(ImuFileSource::open(folder / "none", ImuFormat::kRpg).error().code ==
          ErrorCode::kNotFound);
  }
}

TEST_SUITE("drivers.truth_reader") {
  TEST_CASE("a TUM line has w last, a EuRoC line has w first and may have motion") {
    const TemporaryFolder folder;
    write_file(folder / "a", "1.5 1 2 3 0.0 0.6 0.0 0.8\n");
    auto tum = TruthReader::open(folder / "a", TruthFormat::kTum);
    REQUIRE(tum.ok());
    const auto pose = tum.value().next();
    REQUIRE(pose.ok());
    CHECK(pose.value().stamp_ns == 1'500'000'000);
    CHECK(pose.value().p_world_body_m == std::array<double, 3>{1, 2, 3});
    CHECK(pose.value().q_world_body_xyzw[1] == doctest::Approx(0.6));
    CHECK(pose.value().q_world_body_xyzw[3] == doctest::Approx(0.8));
    CHECK_FALSE(pose.value().has_motion);

    write_file(folder / "b",
               "1500000001,1,2,3,0.8,0,0.6,0,4,5,6,7,8,9,10,11,12\n"
               "2,1,2,3,1,0,0,0\n");
    auto euroc = TruthReader::open(folder / "b", TruthFormat::kEuroc);
    REQUIRE(euroc.ok());
    const auto state = euroc.value().next();
    REQUIRE(state.ok());
    CHECK(state.value().stamp_ns == 1'500'000'001);
    CHECK(state.value().q_world_body_xyzw[1] == doctest::Approx(0.6));
    CHECK(state.value().q_world_body_xyzw[3] == doctest::Approx(0.8));
    REQUIRE(state.value().has_motion);
    CHECK(state.value().v_world_body_mps == std::array<double, 3>{4, 5, 6});
    CHECK(state.value().gyro_bias_radps == std::array<double, 3>{7, 8, 9});
    CHECK(state.value().accel_bias_mps2 == std::array<double, 3>{10, 11, 12});
    const auto bare = euroc.value().next();
    REQUIRE(bare.ok());
    CHECK_FALSE(bare.value().has_motion);
  }

  TEST_CASE("a line with text, NaN or no rotation is counted and skipped") {
    const TemporaryFolder folder;
    write_file(folder / "a",
               "1 1 2 3 0 0 0 nan\n2 1 2 3 0 0 0 0\n3 x 2 3 0 0 0 1\n"
               "4 1 2 3 0 0 0 1 9\n5 1 2 3 0 0 0 1\n");
    auto reader = TruthReader::open(folder / "a", TruthFormat::kTum);
    REQUIRE(reader.ok());
    for (int i = 0; i < 4; ++i) CHECK(reader.value().next().error().code == ErrorCode::kBadNumber);
    CHECK(reader.value().next().ok());
    CHECK(reader.value().malformed() == 4);
    CHECK(reader.value().next().error().code == ErrorCode::kEndOfStream);
  }
}
