#include <algorithm>
#include <array>
#include <cstdio>

#include "drivers/replay/survey_tools.hpp"

namespace pled::replay {
namespace {

/// Median interval of the listed stamps; zero for fewer than two.
[[nodiscard]] double listed_period_s(const Recording& recording) {
  std::vector<std::int64_t> stamps_ns = recording.frame_stamps_ns();
  if (stamps_ns.size() < 2) return 0.0;
  for (std::size_t i = stamps_ns.size() - 1; i > 0; --i) stamps_ns[i] -= stamps_ns[i - 1];
  const auto middle = stamps_ns.begin() + std::ssize(stamps_ns) / 2;
  std::nth_element(stamps_ns.begin() + 1, middle, stamps_ns.end());
  return static_cast<double>(*middle) * 1e-9;
}

/// Takes the stamps of readable frames into a FrameInfo and finds where the camera dropped out.
class FrameGaps {
 public:
  FrameGaps(const Recording& recording, FrameInfo& info)
      : file_(recording.files().frames),
        limit_s_(std::max(kPeriods * listed_period_s(recording), kShortestGap_s)),
        info_(info) {}

  void add(double t_s) {
    if (info_.count++ == 0) info_.first_s = info_.last_s = t_s;
    const double advance_s = t_s - info_.last_s;
    info_.last_s = t_s;
    if (advance_s <= limit_s_) return;
    ++info_.gaps;
    info_.longest_gap_s = std::max(info_.longest_gap_s, advance_s);
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), ": no frame for %.6f s before t = %.6f s", advance_s,
                  t_s);
    found_.push_back(file_ + text.data());
    if (found_.size() > kMaxProblemsOfAKind) found_.pop_back();
  }

  void say(std::vector<std::string>& words) const {
    words.insert(words.end(), found_.begin(), found_.end());
    if (info_.gaps > found_.size())
      words.push_back("... and " + std::to_string(info_.gaps - found_.size()) + " more gaps");
  }

 private:
  static constexpr double kPeriods = 4.5;  ///< as for inertial data, and some rounding
  static constexpr double kShortestGap_s = 0.1;

  const std::string& file_;
  double limit_s_;
  FrameInfo& info_;
  std::vector<std::string> found_;
};

/// Visits every picture that can be read and says which can not.
template <typename Visit>
void read_pictures(RecordedFrameSource& source, std::vector<std::string>& words, const char* kind,
                   const Visit& visit) {
  ProblemList unreadable(words);
  for (;;) {
    const auto frame = source.acquire(Duration{});
    if (frame.ok()) {
      visit(frame.value());
      source.release();
      continue;
    }
    const ErrorCode code = frame.error().code;
    if (code == ErrorCode::kEndOfStream) break;
    unreadable.add(source.last_message());
    if (code != ErrorCode::kTruncated && code != ErrorCode::kCorrupt) break;
  }
  unreadable.finish(kind);
}

}  // namespace

Result<FrameInfo> survey_frames(const Recording& recording, Problems& problems,
                                std::vector<std::string>& words, Progress& progress) {
  auto opened = recording.open_frames(1, problems);
  if (!opened.ok()) return opened.error();
  RecordedFrameSource& source = *opened.value();
  FrameInfo info;
  info.present = true;
  info.width = recording.frame_size().width_px;
  info.height = recording.frame_size().height_px;
  FrameGaps gaps(recording, info);
  read_pictures(source, words, "unreadable frames", [&](const FrameView& frame) {
    progress.at(source.progress());
    gaps.add(frame.t.seconds());
  });
  gaps.say(words);
  say_count(words, recording.files().frames, source.faults().out_of_order,
            "frames whose stamp is not later than the one before (skipped)");
  const double span_s = info.last_s - info.first_s;
  if (span_s > 0) info.rate_hz = static_cast<double>(info.count - 1) / span_s;
  return info;
}

MaskInfo survey_masks(const Recording& recording, std::vector<std::string>& words) {
  MaskInfo info;
  info.present = true;
  Problems problems;
  auto opened = recording.open_masks(1, problems);
  for (const Problem& problem : problems) words.push_back(problem.file + ": " + problem.text);
  if (!opened.ok()) return info;
  FrameFileSource& source = *opened.value();
  read_pictures(source, words, "unreadable label images", [&](const FrameView&) { ++info.count; });
  return info;
}

}  // namespace pled::replay
