#include "tools/owner/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>

namespace bearing_calibration::core {
namespace {

constexpr std::chrono::milliseconds kPeriod(200);

}  // namespace

ProgressBar::ProgressBar(std::uint64_t total, bool visible)
    : total_(std::max<std::uint64_t>(1, total)) {
  if (visible && isatty(STDERR_FILENO) != 0) thread_ = std::thread([this] { follow(); });
}

ProgressBar::~ProgressBar() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }
  ended_changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void ProgressBar::follow() {
  const auto start = std::chrono::steady_clock::now();
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ended_changed_.wait_for(lock, kPeriod, [this] { return ended_; })) {
    draw(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::fputs("\r\x1b[K", stderr);  // the line is cleared
}

void ProgressBar::draw(double seconds) const {
  constexpr int kWidth = 40;  // columns
  const double done = std::min(1.0, static_cast<double>(count_) / static_cast<double>(total_));
  const int filled = static_cast<int>(done * kWidth);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '=') +
                          std::string(static_cast<std::size_t>(kWidth - filled), ' ');
  std::fprintf(stderr, "\r[%s] %3.0f %%", bar.c_str(), 100.0 * done);
  if (done > 0.0) std::fprintf(stderr, ", %.0f s left  ", seconds * (1.0 - done) / done);
  std::fflush(stderr);
}

}  // namespace bearing_calibration::core
