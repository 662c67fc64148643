#pragma once

#include <time.h>

#include <chrono>

namespace bearing_calibration::core {

/// Adds the time until its end to a sum [s].
class Timing {
 public:
  explicit Timing(double* sum_s) : sum_s_(sum_s) {}
  ~Timing() {
    *sum_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Timing(const Timing&) = delete;
  Timing& operator=(const Timing&) = delete;

 private:
  double* sum_s_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// CPU time that this thread takes for some work [ms]: what else the machine does does not count.
template <class Work>
double cpuMillisecondsOf(Work work) {
  const auto now_ms = [] {
    constexpr double kPerSecond = 1e3;
    constexpr double kPerNanosecond = 1e-6;
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return kPerSecond * static_cast<double>(now.tv_sec) +
           kPerNanosecond * static_cast<double>(now.tv_nsec);
  };
  const double begin_ms = now_ms();
  work();
  return now_ms() - begin_ms;
}

}  // namespace bearing_calibration::core
