#pragma once

#include <cstdint>
#include <optional>

#include "pled_vins/core/timestamp.hpp"

namespace pled {

/// Tells stamps that went wrong from a clock that was set: a few wild stamps are dropped and the
/// stream goes on from before them; when as many as `needed` in a row follow each other closely,
/// away from what was before, the clock itself has jumped.
class StampGuard {
 public:
  enum class Verdict : std::uint8_t {
    kGood,
    kWild,    ///< to be dropped
    kJumped,  ///< to be taken: from here on there is another clock
  };

  explicit StampGuard(int needed) noexcept : needed_(needed) {}

  /// Stamps that do not increase are wild only when they lie further back than kLongest; small
  /// steps back and repeated stamps are for others to judge.
  [[nodiscard]] Verdict judge(Timestamp t) noexcept {
    if (!last_ || near(*last_, t)) return take(t, Verdict::kGood);
    run_ = wild_ && near(*wild_, t) && t > *wild_ ? run_ + 1 : 1;
    wild_ = t;
    return run_ >= needed_ ? take(t, Verdict::kJumped) : Verdict::kWild;
  }
  /// Takes this stamp for the last good one.
  void restart(std::optional<Timestamp> t) noexcept {
    last_ = t;
    wild_.reset();
    run_ = 0;
  }
  [[nodiscard]] std::optional<Timestamp> last() const noexcept { return last_; }

  static constexpr Duration kLongest{2'000'000};  ///< between stamps of one clock

 private:
  [[nodiscard]] static bool near(Timestamp a, Timestamp b) noexcept {
    return b - a <= kLongest && a - b <= kLongest;
  }
  Verdict take(Timestamp t, Verdict verdict) noexcept {
    restart(last_ && verdict == Verdict::kGood && t < *last_ ? *last_ : t);
    return verdict;
  }

  int needed_;
  int run_ = 0;
  std::optional<Timestamp> last_;
  std::optional<Timestamp> wild_;
};

}  // namespace pled
