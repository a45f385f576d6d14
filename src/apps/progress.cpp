#include "src/apps/progress.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

namespace pled::apps {
namespace {

constexpr double kRedrawEvery_s = 0.1;
constexpr double kShortJob_s = 1.0;
constexpr int kBarWidth = 30;
constexpr int kPercentStep = 10;

double steady_s() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

double left_s(double share, double elapsed_s) {
  return share > 0 ? elapsed_s * (1.0 - share) / share : 0.0;
}

/// Characters that fit on a line of the terminal; a longer bar would leave its rests.
int columns_of(std::FILE* out, int otherwise) {
  winsize size{};
  const bool known = ioctl(fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? std::min(size.ws_col - 1, otherwise) : otherwise;
}

}  // namespace

Progress::Progress(std::FILE* out, bool on_terminal, double total, Clock clock, Kind kind)
    : out_(out),
      on_terminal_(on_terminal),
      total_(total),
      clock_(std::move(clock)),
      kind_(kind),
      started_s_(clock_()) {}

Progress Progress::on_stderr(double total_s) {
  return {stderr, isatty(STDERR_FILENO) != 0, total_s, steady_s};
}

Progress Progress::share_on_stderr() {
  return {stderr, isatty(STDERR_FILENO) != 0, 1.0, steady_s, Kind::kShare};
}

void Progress::update(double done, std::string_view words) {
  done_ = done;
  if (!(total_ > 0)) return;
  const double share = std::clamp(done / total_, 0.0, 1.0);
  const int percent = static_cast<int>(share * 100.0);
  if (!on_terminal_ && percent < next_percent_) return;
  const double now_s = clock_();
  const double elapsed_s = now_s - started_s_;
  if (kind_ == Kind::kShare && elapsed_s < kShortJob_s) return;
  if (on_terminal_ && now_s - drawn_s_ < kRedrawEvery_s) return;
  drawn_s_ = now_s;
  if (on_terminal_) return draw_bar(share, elapsed_s, words);
  print_line(share, elapsed_s, words);
  next_percent_ = (percent / kPercentStep + 1) * kPercentStep;
}

void Progress::finish() {
  // The bar is wiped: what it said was for the time of waiting only.
  if (on_terminal_) std::fputs("\r\033[K", out_);
  if (kind_ == Kind::kRecording) {
    const double elapsed_s = clock_() - started_s_;
    const double speed = elapsed_s > 0 ? done_ / elapsed_s : 0.0;
    std::fprintf(out_, "done: %.1f s of recording in %.1f s, %.1fx real time\n", done_, elapsed_s,
                 speed);
  }
  std::fflush(out_);
}

void Progress::print_line(double share, double elapsed_s, std::string_view words) {
  std::fprintf(out_, "%d %%", static_cast<int>(share * 100.0));
  if (kind_ == Kind::kRecording)
    std::fprintf(out_, ", %.1f of %.1f s, %.1fx real time", done_, total_,
                 elapsed_s > 0 ? done_ / elapsed_s : 0.0);
  std::fprintf(out_, ", %.0f s left%s%.*s\n", left_s(share, elapsed_s), words.empty() ? "" : ", ",
               static_cast<int>(words.size()), words.data());
}

void Progress::draw_bar(double share, double elapsed_s, std::string_view words) {
  const int full = static_cast<int>(std::lround(share * kBarWidth));
  std::array<char, kBarWidth + 1> bar{};  // no allocation: a replay counts them
  for (int i = 0; i < kBarWidth; ++i) bar[static_cast<std::size_t>(i)] = i < full ? '#' : '-';
  std::array<char, 48> speed{};
  if (kind_ == Kind::kRecording && elapsed_s > 0)
    std::snprintf(speed.data(), speed.size(), "  %.1fx real time", done_ / elapsed_s);
  std::array<char, 256> line{};
  const int length = std::snprintf(
      line.data(), line.size(), "[%s] %3.0f %%%s  %.0f s left  %.*s", bar.data(), share * 100.0,
      speed.data(), left_s(share, elapsed_s), static_cast<int>(words.size()), words.data());
  const int shown = std::min(length, columns_of(out_, static_cast<int>(line.size()) - 1));
  std::fprintf(out_, "\r\033[K%.*s", shown, line.data());
  std::fflush(out_);
}

}  // namespace pled::apps
