#pragma once

#include <cstdint>
#include <optional>

namespace pled::apps {

/// Processor time and allocations of the process between start() and stop(), 0 when not started;
/// and its largest resident size at stop().
class ReplayMeters {
 public:
  void start();
  void stop();
  [[nodiscard]] double cpu_s() const { return cpu_s_; }
  [[nodiscard]] std::uint64_t peak_rss_bytes() const { return peak_rss_bytes_; }
  [[nodiscard]] std::optional<std::uint64_t> allocations() const { return allocations_; }

 private:
  bool running_ = false;
  double cpu_s_ = 0.0;
  std::uint64_t peak_rss_bytes_ = 0;
  std::optional<std::uint64_t> allocations_;
};

}  // namespace pled::apps
