#include "pled_vins/frontend/lines/line_match.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr double kMaxTurn_rad = 6.0 * std::numbers::pi / 180.0;
constexpr double kMinCommonShare = 0.5;
/// The nearest of several must be so much nearer for its place alone to tell.
constexpr float kClear_px = 2.0F;
/// Bits: of one near alone, so different it is something else; among several as near, so alike it
/// must be, and so much more than the next.
constexpr int kOtherThing = 100;
constexpr int kAlike = 40;
constexpr int kClearBits = 10;

constexpr float kNever = std::numeric_limits<float>::infinity();

/// What each expected line has to do with each one seen.
struct Table {
  std::array<std::array<float, limits::kMaxLines>, limits::kMaxLines> apart_px;
  std::array<std::array<std::int16_t, limits::kMaxLines>, limits::kMaxLines> bits;
};

float apart_px(const ExpectedLine& expected, const DetectedLine& seen, double search_px) noexcept {
  if (expected.segment.active_is_bright != seen.segment.active_is_bright) return kNever;
  if (!may_run_alike(expected.segment, seen.segment, kMaxTurn_rad)) return kNever;
  const BesideSegment at = beside(expected.segment, seen.segment);
  const double shorter = std::min(expected.segment.length_px(), seen.segment.length_px());
  if (!(at.common_px >= kMinCommonShare * shorter)) return kNever;
  if (!(at.farthest_px <= search_px)) return kNever;
  if (!(std::abs(at.angle_rad()) <= kMaxTurn_rad)) return kNever;
  return static_cast<float>(at.farthest_px);
}

/// Of `count` candidates the one that is certain, or kNoLine.
template <typename Apart, typename Bits>
std::int16_t choose(std::size_t count, const Apart& apart, const Bits& bits) noexcept {
  float nearest = kNever;
  for (std::size_t i = 0; i < count; ++i) nearest = std::min(nearest, apart(i));
  if (nearest == kNever) return kNoLine;
  std::int16_t best = kNoLine;
  int best_bits = kDescriptorBits + 1;
  int next_bits = kDescriptorBits + 1;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(apart(i) < nearest + kClear_px)) continue;
    const int b = bits(i);
    if (b < best_bits) {
      next_bits = best_bits;
      best_bits = b;
      best = static_cast<std::int16_t>(i);
    } else {
      next_bits = std::min(next_bits, b);
    }
  }
  const bool alone = next_bits > kDescriptorBits;
  if (alone) return best_bits < kOtherThing ? best : kNoLine;
  return best_bits < kAlike && next_bits - best_bits >= kClearBits ? best : kNoLine;
}

}  // namespace

void match_lines(std::span<const ExpectedLine> expected, std::span<const DetectedLine> seen,
                 double search_px, std::span<std::int16_t> match) noexcept {
  PLED_CHECK(expected.size() <= limits::kMaxLines && seen.size() <= limits::kMaxLines);
  PLED_CHECK(match.size() == expected.size());
  Table table;
  for (std::size_t i = 0; i < expected.size(); ++i)
    for (std::size_t k = 0; k < seen.size(); ++k) {
      table.apart_px[i][k] = apart_px(expected[i], seen[k], search_px);
      if (table.apart_px[i][k] == kNever) continue;  // nobody asks
      table.bits[i][k] =
          static_cast<std::int16_t>(distance(expected[i].descriptor, seen[k].descriptor));
    }
  std::fill(match.begin(), match.end(), kNoLine);
  std::array<bool, limits::kMaxLines> taken{};
  for (const bool was_seen : {true, false}) {
    const auto of_expected = [&](std::size_t i) {
      return choose(
          seen.size(), [&](std::size_t k) { return taken[k] ? kNever : table.apart_px[i][k]; },
          [&](std::size_t k) { return int{table.bits[i][k]}; });
    };
    const auto of_seen = [&](std::size_t k) {
      return choose(
          expected.size(),
          [&](std::size_t i) {
            return expected[i].was_seen == was_seen ? table.apart_px[i][k] : kNever;
          },
          [&](std::size_t i) { return int{table.bits[i][k]}; });
    };
    std::array<bool, limits::kMaxLines> given{};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (expected[i].was_seen != was_seen) continue;
      const std::int16_t k = of_expected(i);
      if (k == kNoLine || of_seen(static_cast<std::size_t>(k)) != static_cast<std::int16_t>(i))
        continue;
      match[i] = k;
      given[static_cast<std::size_t>(k)] = true;
    }
    for (std::size_t k = 0; k < seen.size(); ++k) taken[k] = taken[k] || given[k];
  }
}

}  // namespace pled
