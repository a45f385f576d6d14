#include "src/apps/progress.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include <doctest/doctest.h>

namespace {

/// What a Progress printed, as text.
class Paper {
 public:
  Paper() : file_(std::tmpfile()) { REQUIRE(file_ != nullptr); }
  Paper(const Paper&) = delete;
  Paper& operator=(const Paper&) = delete;
  ~Paper() { std::fclose(file_); }
  [[nodiscard]] std::FILE* file() const { return file_; }
  [[nodiscard]] std::string text() const {
    std::string out(static_cast<std::size_t>(std::ftell(file_)), '\0');
    std::rewind(file_);
    out.resize(std::fread(out.data(), 1, out.size(), file_));
    return out;
  }

 private:
  std::FILE* file_;
};

TEST_SUITE("apps.progress") {
  TEST_CASE("without a terminal there are plain lines, one each ten percent") {
    const Paper paper;
    double now_s = 100.0;
    pled::apps::Progress progress(paper.file(), false, 20.0, [&] { return now_s; });
    for (int i = 0; i <= 2000; ++i) {
      now_s = 100.0 + 0.002 * i;  // 5x real time
      progress.update(0.01 * i);
    }
    const std::string text = paper.text();
    CHECK(std::count(text.begin(), text.end(), '\n') == 10);
    CHECK(text.find('\r') == std::string::npos);
    CHECK(text.starts_with("10 %, 2.0 of 20.0 s, 5.0x real time, 4 s left\n"));
    CHECK(text.find("\n100 %, 20.0 of 20.0 s, 5.0x real time, 0 s left\n") != std::string::npos);
  }

  TEST_CASE("a jump over several steps says one line") {
    const Paper paper;
    double now_s = 0.0;
    pled::apps::Progress progress(paper.file(), false, 10.0, [&] { return now_s; });
    now_s = 1.0;
    progress.update(5.5, "12 points");
    progress.update(5.9);
    CHECK(paper.text() == "55 %, 5.5 of 10.0 s, 5.5x real time, 1 s left, 12 points\n");
  }

  TEST_CASE("on a terminal one line is drawn anew, at most ten times a second") {
    const Paper paper;
    double now_s = 0.0;
    pled::apps::Progress progress(paper.file(), true, 10.0, [&] { return now_s; });
    for (int i = 1; i <= 1000; ++i) {
      now_s = 0.001 * i;
      progress.update(0.01 * i);
    }
    const std::string text = paper.text();
    const auto drawn = std::count(text.begin(), text.end(), '\r');
    CHECK(drawn >= 9);
    CHECK(drawn <= 11);
    CHECK(text.find('\n') == std::string::npos);
    CHECK(text.find("10.0x real time") != std::string::npos);
  }

  TEST_CASE("an unknown length says nothing until the end") {
    const Paper paper;
    double now_s = 0.0;
    pled::apps::Progress progress(paper.file(), false, 0.0, [&] { return now_s; });
    now_s = 2.0;
    progress.update(6.0);
    progress.finish();
    CHECK(paper.text() == "done: 6.0 s of recording in 2.0 s, 3.0x real time\n");
  }

  TEST_CASE("a share of a job is told without speed, and not at all when the job is short") {
    double now_s = 0.0;
    const auto clock = [&] { return now_s; };
    const auto work = [&](pled::apps::Progress progress, double takes_s) {
      for (int i = 1; i <= 4; ++i) {
        now_s += 0.25 * takes_s;
        progress.update(0.25 * i);
      }
      progress.finish();
    };
    using pled::apps::Progress;
    const Paper quick;
    work({quick.file(), false, 1.0, clock, Progress::Kind::kShare}, 0.9);
    CHECK(quick.text() == "");
    const Paper slow;
    work({slow.file(), false, 1.0, clock, Progress::Kind::kShare}, 8.0);
    CHECK(slow.text() == "25 %, 6 s left\n50 %, 4 s left\n75 %, 2 s left\n100 %, 0 s left\n");
    const Paper bar;
    work({bar.file(), true, 1.0, clock, Progress::Kind::kShare}, 8.0);
    CHECK(bar.text().find("] 100 %  0 s left") != std::string::npos);
    CHECK(bar.text().find("real time") == std::string::npos);
    CHECK(bar.text().ends_with("\r\033[K"));
  }
}

}  // namespace
