#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay/recording_info.hpp"

/// What the surveys of the single streams share.
namespace pled::replay {

/// Says the first few problems of a kind and counts the others.
class ProblemList {
 public:
  explicit ProblemList(std::vector<std::string>& out) : out_(out) {}
  void add(std::string_view text) {
    if (++count_ <= kMaxProblemsOfAKind) out_.emplace_back(text);
  }
  void finish(const std::string& kind) {
    if (count_ > kMaxProblemsOfAKind) {
      out_.push_back("... and " + std::to_string(count_ - kMaxProblemsOfAKind) + " more " + kind);
    }
  }

 private:
  std::vector<std::string>& out_;
  std::uint64_t count_ = 0;
};

/// Rising progress over the streams, each with a share of the whole.
class Progress {
 public:
  explicit Progress(const std::function<void(double)>& report) : report_(report) {}
  void next_stream(double share) {
    begin_ += share_;
    share_ = share;
    at(0.0);
  }
  void at(double part) {
    const double value = std::min(begin_ + share_ * std::clamp(part, 0.0, 1.0), 1.0);
    if (report_ && value >= last_ + kStep) report_(last_ = value);
  }
  void finish() {
    if (report_) report_(1.0);
  }

 private:
  static constexpr double kStep = 1e-3;
  const std::function<void(double)>& report_;
  double begin_ = 0.0;
  double share_ = 0.0;
  double last_ = -kStep;
};

inline void say_count(std::vector<std::string>& problems, const std::string& file,
                      std::uint64_t count, const char* what) {
  if (count > 0) problems.push_back(file + ": " + std::to_string(count) + " " + what);
}

/// Median of intervals in whole microseconds, exact up to kMaxUs, in fixed memory.
class IntervalMedian {
 public:
  void add(std::int64_t interval_us) {
    ++counts_[static_cast<std::size_t>(std::clamp<std::int64_t>(interval_us, 0, kMaxUs))];
    ++total_;
  }
  /// Zero without intervals.
  [[nodiscard]] std::int64_t median_us() const {
    std::uint64_t below = 0;
    for (std::size_t us = 0; us < counts_.size(); ++us) {
      below += counts_[us];
      if (2 * below > total_) return static_cast<std::int64_t>(us);
    }
    return 0;
  }

 private:
  static constexpr std::int64_t kMaxUs = 1'000'000;
  std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(kMaxUs + 1);
  std::uint64_t total_ = 0;
};

/// Counts frames and label images, with what is missing from them in `words`.
[[nodiscard]] Result<FrameInfo> survey_frames(const Recording& recording, Problems& problems,
                                              std::vector<std::string>& words, Progress& progress);
[[nodiscard]] MaskInfo survey_masks(const Recording& recording, std::vector<std::string>& words);

}  // namespace pled::replay
