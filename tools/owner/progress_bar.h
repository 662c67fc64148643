#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

namespace bearing_calibration::core {

/// A line on standard error that follows a count until the bar is destroyed; nothing where standard
/// error is no terminal.
class ProgressBar {
 public:
  /// @param visible  false: count only
  ProgressBar(std::uint64_t total, bool visible);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  std::atomic<std::uint64_t>* count() { return &count_; }

 private:
  void follow();
  void draw(double seconds) const;

  std::uint64_t total_;
  std::atomic<std::uint64_t> count_{0};
  std::mutex mutex_;
  std::condition_variable ended_changed_;
  bool ended_ = false;
  std::thread thread_;  ///< last: it uses the others
};

}  // namespace bearing_calibration::core
