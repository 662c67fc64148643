#pragma once

#include <atomic>
#include <cstddef>
#include <future>
#include <vector>

namespace bearing_calibration::core {

/// Calls work(0) ... work(count - 1), so many at a time.
/// @throws what one of them throws; no further one begins then
template <typename Work>
void forEachInParallel(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto serve = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    } catch (...) {
      next = count;
      throw;
    }
  };
  std::vector<std::future<void>> servers;
  for (int i = 0; i < threads; ++i) servers.push_back(std::async(std::launch::async, serve));
  for (std::future<void>& server : servers) server.get();
}

}  // namespace bearing_calibration::core
