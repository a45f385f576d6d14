#include "pled_vins/evaluation/trajectory.hpp"

#include <cstdint>
#include <string>

#include <doctest/doctest.h>

#include "unit/config/text_file.hpp"

namespace {

using pled::FileError;
using pled::FrameStamps;
using pled::Trajectory;
using pled::support::TextFile;

pled::FileError error_of(const std::string& text) {
  const TextFile file("trajectory.txt", text);
  const auto read = pled::read_trajectory(file.path());
  REQUIRE(std::holds_alternative<FileError>(read));
  return std::get<FileError>(read);
}

TEST_SUITE("evaluation.trajectory") {
  TEST_CASE("a stamp in seconds becomes exactly its nanoseconds") {
    struct Case {
      const char* text;
      std::int64_t ns;
    };
    for (const Case& c :
         {Case{"1403715273.262143135", 1403715273262143135}, Case{"0.05", 50'000'000},
          Case{"12", 12'000'000'000}, Case{".5", 500'000'000}, Case{"-0.000000001", -1},
          Case{"0.0000000015", 2}, Case{"0.0000000014", 1},
          Case{"1.403715273262143135e+09", 1403715273262143135}, Case{"25e-3", 25'000'000}}) {
      CAPTURE(c.text);
      std::int64_t ns = -7;
      CHECK(pled::parse_stamp_s(c.text, ns));
      CHECK(ns == c.ns);
    }
  }

  TEST_CASE("what is no stamp is refused and changes nothing") {
    for (const char* text :
         {"", ".", "nan", "1.2.3", "12s", "1e", "--1", "99999999999999999999", "1e99", "0x10"}) {
      CAPTURE(text);
      std::int64_t ns = -7;
      CHECK_FALSE(pled::parse_stamp_s(text, ns));
      CHECK(ns == -7);
    }
  }

  TEST_CASE("a TUM file keeps the order x y z w and normalises the quaternion") {
    const TextFile file("a.tum",
                        "# t tx ty tz qx qy qz qw\n\n0.5 1 2 3 0 0 0 2\n1.5 4 5 6 2 0 0 0\r\n");
    const auto read = pled::read_trajectory(file.path());
    REQUIRE(std::holds_alternative<Trajectory>(read));
    const auto& trajectory = std::get<Trajectory>(read);
    REQUIRE(trajectory.size() == 2);
    CHECK(trajectory[0].stamp_ns == 500'000'000);
    CHECK(trajectory[0].pose.p == Eigen::Vector3d(1, 2, 3));
    CHECK(trajectory[0].pose.q.w() == 1.0);
    CHECK(trajectory[1].pose.q.x() == 1.0);
  }

  TEST_CASE("a EuRoC csv has nanoseconds, w first, and may go on with biases") {
    const TextFile file(
        "data.csv", "#timestamp, p_x, ...\n1403715524922140000,1,2,3,0,0,1,0,9,9,9,9,9,9,9,9,9\n");
    const auto read = pled::read_trajectory(file.path());
    REQUIRE(std::holds_alternative<Trajectory>(read));
    const auto& pose = std::get<Trajectory>(read).at(0);
    CHECK(pose.stamp_ns == 1403715524922140000);
    CHECK(pose.pose.p == Eigen::Vector3d(1, 2, 3));
    CHECK(pose.pose.q.y() == 1.0);
  }

  TEST_CASE("a bad line is named with its number and what is wrong") {
    struct Case {
      const char* text;
      int line;
      const char* words;
    };
    for (const Case& c :
         {Case{"0 1 2 3 0 0 0 1\n1 nan 2 3 0 0 0 1\n", 2, "'nan' is not a finite number"},
          Case{"# head\n0 1 2 3 0 0 0\n", 2, "7 columns"},
          Case{"0 1 2 3 0 0 0 1 9\n", 1, "9 columns"},
          Case{"0 1 2 3 0 0 0 0\n", 1, "quaternion is zero"}, Case{"0 1 x 3 0 0 0 1\n", 1, "'x'"},
          Case{"a 1 2 3 0 0 0 1\n", 1, "'a' is not a time"},
          Case{"1 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 1\n", 2, "not later"},
          Case{"1 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n", 2, "not later"},
          Case{"5,1,2\n", 1, "3 columns"}}) {
      CAPTURE(c.text);
      const FileError error = error_of(c.text);
      CHECK(error.line == c.line);
      CHECK(error.text.find(c.words) != std::string::npos);
      CHECK(error.message().find("trajectory.txt:" + std::to_string(c.line)) != std::string::npos);
    }
  }

  TEST_CASE("a missing file and a folder are told apart, an empty file is an empty trajectory") {
    const auto missing = pled::read_trajectory("no/such/file");
    REQUIRE(std::holds_alternative<FileError>(missing));
    CHECK(std::get<FileError>(missing).message() == "no/such/file: there is no such file");
    const auto folder = pled::read_trajectory(".");
    REQUIRE(std::holds_alternative<FileError>(folder));
    CHECK(std::get<FileError>(folder).text.find("folder") != std::string::npos);
    const TextFile empty("empty.tum", "");
    const auto read = pled::read_trajectory(empty.path());
    REQUIRE(std::holds_alternative<Trajectory>(read));
    CHECK(std::get<Trajectory>(read).empty());
  }

  TEST_CASE("frame stamps are read from images.txt and from a EuRoC csv") {
    const TextFile text("images.txt", "0.05 images/a.png\n0.10 images/b.png\n");
    const auto a = pled::read_frame_stamps(text.path());
    REQUIRE(std::holds_alternative<FrameStamps>(a));
    CHECK(std::get<FrameStamps>(a).ns == std::vector<std::int64_t>{50'000'000, 100'000'000});
    CHECK(std::get<FrameStamps>(a).passed_over == 0);
    const TextFile csv("data.csv", "#timestamp [ns],filename\n7,7.png\n9,9.png\n");
    const auto b = pled::read_frame_stamps(csv.path());
    REQUIRE(std::holds_alternative<FrameStamps>(b));
    CHECK(std::get<FrameStamps>(b).ns == std::vector<std::int64_t>{7, 9});
  }

  TEST_CASE("lines of a frame list that a replay passes over are passed over and counted") {
    const TextFile text("images.txt",
                        "0.05 a.png\n0.07\nx b.png\n0.04 c.png\n0.05 d.png\n0.10 e.png\n");
    const auto read = pled::read_frame_stamps(text.path());
    REQUIRE(std::holds_alternative<FrameStamps>(read));
    CHECK(std::get<FrameStamps>(read).ns == std::vector<std::int64_t>{50'000'000, 100'000'000});
    CHECK(std::get<FrameStamps>(read).passed_over == 4);
    CHECK(std::holds_alternative<FileError>(pled::read_frame_stamps("no such file")));
  }
}

}  // namespace
