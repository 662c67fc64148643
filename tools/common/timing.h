#pragma once

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

}  // namespace bearing_calibration::core
