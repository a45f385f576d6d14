#include "src/apps/recording_clocks.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "drivers/decode/decimal.hpp"

namespace pled::apps {
namespace {

/// Frames and inertial samples side by side.
class Overlap {
 public:
  /// `frames_us`: increasing, at least one.
  explicit Overlap(std::vector<std::int64_t> frames_us) : frames_us_(std::move(frames_us)) {}

  void add(std::int64_t sample_us) {
    first_us_ = samples_++ == 0 ? sample_us : std::min(first_us_, sample_us);
    last_us_ = std::max(samples_ == 1 ? sample_us : last_us_, sample_us);
    if (sample_us >= frames_us_.front() && sample_us <= frames_us_.back()) ++samples_inside_;
  }

  /// One of each is chance: in another unit, zero is still zero.
  [[nodiscard]] bool enough() const {
    constexpr std::int64_t kShort_us = 500'000;
    const bool is_short = frames_us_.back() - frames_us_.front() < kShort_us;
    return frames_inside() >= std::min<std::ptrdiff_t>(2, std::ssize(frames_us_)) &&
           (is_short || samples_inside_ >= 2);
  }

  [[nodiscard]] bool has_samples() const { return samples_ > 0; }

  /// What the two cover, and how little of it they share.
  [[nodiscard]] std::string words(const std::string& frames, const std::string& imu) const {
    std::array<char, 160> spans{};
    std::snprintf(spans.data(), spans.size(), " covers %.6f ... %.6f s, ", seconds(frames_us_[0]),
                  seconds(frames_us_.back()));
    std::string out = frames + spans.data();
    std::snprintf(spans.data(), spans.size(), " covers %.6f ... %.6f s: ", seconds(first_us_),
                  seconds(last_us_));
    out += imu + spans.data();
    const bool apart = last_us_ < frames_us_.front() || first_us_ > frames_us_.back();
    return out + (apart ? "no overlap" : "hardly any overlap");
  }

 private:
  static double seconds(std::int64_t us) { return static_cast<double>(us) * 1e-6; }

  [[nodiscard]] std::ptrdiff_t frames_inside() const {
    if (samples_ == 0) return 0;
    return std::upper_bound(frames_us_.begin(), frames_us_.end(), last_us_) -
           std::lower_bound(frames_us_.begin(), frames_us_.end(), first_us_);
  }

  std::vector<std::int64_t> frames_us_;
  std::int64_t first_us_ = 0;  ///< of the samples
  std::int64_t last_us_ = 0;
  std::uint64_t samples_ = 0;
  std::uint64_t samples_inside_ = 0;  ///< between the first frame and the last
};

}  // namespace

std::string clock_problem(const replay::Recording& recording, double time_shift_s) {
  std::vector<std::int64_t> frames_us = recording.frame_stamps_ns();
  if (frames_us.empty()) return recording.files().frames + ": no stamp can be read";
  const Duration shift = Duration::from_s(time_shift_s);
  for (std::int64_t& stamp : frames_us) stamp = rounded_to_us(stamp) + shift.us;
  Overlap overlap(std::move(frames_us));

  replay::Problems problems;
  auto imu = recording.open_imu(problems);
  if (!imu.ok()) return problems.empty() ? std::string() : to_string(problems.front());
  while (!overlap.enough()) {
    const Result<ImuSample> sample = imu.value()->read(Duration{});
    if (sample.ok())
      overlap.add(sample.value().t.us);
    else if (sample.error().code != ErrorCode::kBadNumber)
      break;
  }
  if (overlap.enough()) return {};
  if (!overlap.has_samples()) {
    std::string words = recording.files().imu + ": holds no sample that can be read";
    if (imu.value()->malformed() > 0) words.append("; ").append(imu.value()->last_message());
    return words;
  }
  std::string words = overlap.words(recording.files().frames, recording.files().imu);
  if (recording.container() != nullptr) return words;
  const bool euroc = recording.layout() == replay::Layout::kEuroc;
  return words + "; stamps must be " + (euroc ? "nanoseconds" : "seconds") + " on one clock";
}

}  // namespace pled::apps
