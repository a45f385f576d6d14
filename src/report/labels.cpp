#include "src/report/labels.hpp"

#include <cmath>
#include <cstdlib>

namespace pled::report {
namespace {

/// Lists may have been written with fewer digits than the results.
constexpr std::int64_t kSameStamp_ns = 1'000'000;
constexpr std::uint8_t kMovingLabel = 255;

}  // namespace

Labels::Labels(const replay::Recording* recording) {
  if (recording == nullptr || !recording->has(replay::Stream::kMasks)) return;
  replay::Problems ignored;  // no labels is an answer
  auto opened = recording->open_masks(1, ignored);
  if (opened.ok()) source_ = std::move(opened).value();
  advance();
}

void Labels::advance() {
  if (current_) source_->release();
  current_.reset();
  while (source_) {
    const auto image = source_->acquire(Duration{});
    if (image.ok()) {
      current_ = image.value();
      return;
    }
    const ErrorCode code = image.error().code;
    if (code != ErrorCode::kCorrupt && code != ErrorCode::kTruncated) return;
  }
}

std::optional<ImageView<const std::uint8_t>> Labels::at(std::int64_t stamp_ns) {
  while (current_ && current_->stamp_ns < stamp_ns - kSameStamp_ns) advance();
  if (!current_ || current_->stamp_ns > stamp_ns + kSameStamp_ns) return std::nullopt;
  return current_->image;
}

bool is_moving(ImageView<const std::uint8_t> labels, double u_px, double v_px) {
  const auto x = static_cast<int>(std::lround(u_px));
  const auto y = static_cast<int>(std::lround(v_px));
  if (x < 0 || y < 0 || x >= labels.width || y >= labels.height) return false;
  return labels.at(y, x) == kMovingLabel;
}

}  // namespace pled::report
