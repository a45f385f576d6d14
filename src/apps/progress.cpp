#include "src/apps/progress.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include <unistd.h>

namespace pled::apps {
namespace {

constexpr double kRedrawEvery_s = 0.1;
constexpr int kBarWidth = 30;
constexpr int kPercentStep = 10;

}  // namespace

Progress::Progress(std::FILE* out, bool on_terminal, double total_s, Clock clock)
    : out_(out),
      on_terminal_(on_terminal),
      total_s_(total_s),
      clock_(std::move(clock)),
      started_s_(clock_()) {}

Progress Progress::on_stderr(double total_s) {
  return {stderr, isatty(STDERR_FILENO) != 0, total_s, [] {
            const auto now = std::chrono::steady_clock::now().time_since_epoch();
            return std::chrono::duration<double>(now).count();
          }};
}

void Progress::update(double done_s, std::string_view words) {
  done_s_ = done_s;
  if (!(total_s_ > 0)) return;
  const double share = std::clamp(done_s / total_s_, 0.0, 1.0);
  const int percent = static_cast<int>(share * 100.0);
  if (!on_terminal_ && percent < next_percent_) return;
  const double now_s = clock_();
  if (on_terminal_ && now_s - drawn_s_ < kRedrawEvery_s) return;
  drawn_s_ = now_s;
  const double elapsed_s = now_s - started_s_;
  const double speed = elapsed_s > 0 ? done_s / elapsed_s : 0.0;
  const double left_s = speed > 0 ? std::max(0.0, (total_s_ - done_s) / speed) : 0.0;
  if (on_terminal_) return draw_bar(share, speed, left_s, words);
  std::fprintf(out_, "%d %%, %.1f of %.1f s, %.1fx real time, %.0f s left%s%.*s\n", percent, done_s,
               total_s_, speed, left_s, words.empty() ? "" : ", ", static_cast<int>(words.size()),
               words.data());
  next_percent_ = (percent / kPercentStep + 1) * kPercentStep;
}

void Progress::finish() {
  const double elapsed_s = clock_() - started_s_;
  const double speed = elapsed_s > 0 ? done_s_ / elapsed_s : 0.0;
  // The bar is wiped: what it said was for the time of waiting only.
  std::fprintf(out_, "%sdone: %.1f s of recording in %.1f s, %.1fx real time\n",
               on_terminal_ ? "\r\033[K" : "", done_s_, elapsed_s, speed);
  std::fflush(out_);
}

void Progress::draw_bar(double share, double speed, double left_s, std::string_view words) {
  const int full = static_cast<int>(std::lround(share * kBarWidth));
  std::array<char, kBarWidth + 1> bar{};  // no allocation: a replay counts them
  for (int i = 0; i < kBarWidth; ++i) bar[static_cast<std::size_t>(i)] = i < full ? '#' : '-';
  std::fprintf(out_, "\r\033[K[%s] %3.0f %%  %.1fx real time  %.0f s left  %.*s", bar.data(),
               share * 100.0, speed, left_s, static_cast<int>(words.size()), words.data());
  std::fflush(out_);
}

}  // namespace pled::apps
