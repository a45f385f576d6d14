#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace pled::sim {

/// Runs work(0) ... work(count - 1), each once, on all processors. Which thread
/// runs which item is open, so items must not share what they write.
template <typename Work>
void parallel_for(std::size_t count, const Work& work) {
  const std::size_t threads = std::min<std::size_t>(
      count,
      std::max<std::size_t>(1, std::min<std::size_t>(std::thread::hardware_concurrency(), 16)));
  std::atomic<std::size_t> next{0};
  const auto loop = [&] {
    for (std::size_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) work(i);
  };
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < threads; ++i) others.emplace_back(loop);
  loop();
}

}  // namespace pled::sim
