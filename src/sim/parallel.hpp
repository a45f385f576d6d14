#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace pled::sim {

/// Runs work(0) ... work(count - 1), each once, on all processors. Which thread
/// runs which item is open, so items must not share what they write. An exception
/// of an item leaves the call when all threads have ended.
template <typename Work>
void parallel_for(std::size_t count, const Work& work) {
  const std::size_t threads = std::min<std::size_t>(
      count,
      std::max<std::size_t>(1, std::min<std::size_t>(std::thread::hardware_concurrency(), 16)));
  std::atomic<std::size_t> next{0};
  std::mutex guard;
  std::exception_ptr failure;
  const auto loop = [&] {
    try {
      for (std::size_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) work(i);
    } catch (...) {
      next = count;
      const std::scoped_lock lock(guard);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < threads; ++i) others.emplace_back(loop);
    loop();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace pled::sim
