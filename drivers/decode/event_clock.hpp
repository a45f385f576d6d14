#pragma once

#include <cstdint>

#include "pled_vins/hal/event_source.hpp"

namespace pled {

/// The time of decoded events. It does not go back for single stamps: one below the last is held
/// there and counted. Ours: kPatience of them in a row that lie more than kFar_us below it and
/// follow each other are a clock that was set back; time goes on from the newest of them, and a gap
/// is counted.
class EventClock {
 public:
  static constexpr int kPatience = 64;
  static constexpr std::int64_t kFar_us = 2'000'000;

  [[nodiscard]] bool has_time() const noexcept { return has_time_; }
  /// Of the last event; zero before the first.
  [[nodiscard]] std::int64_t last_us() const noexcept { return last_us_; }
  /// The event with the stamp that it is given out with.
  [[nodiscard]] Event held(Event event, DecoderFaults& faults) noexcept;

 private:
  [[nodiscard]] bool was_set_back(std::int64_t t_us) noexcept;

  bool has_time_ = false;
  std::int64_t last_us_ = 0;
  int run_ = 0;               ///< stamps far back that followed each other
  std::int64_t back_us_ = 0;  ///< the last of them
};

}  // namespace pled
