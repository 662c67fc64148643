#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace bearing_calibration::core {

/// Calls work(0) ... work(count - 1), so many at a time. `work` throws nothing.
template <typename Work>
void forEachInParallel(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto serve = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::thread> servers;
  for (int i = 0; i < threads; ++i) servers.emplace_back(serve);
  for (std::thread& server : servers) server.join();
}

}  // namespace bearing_calibration::core
