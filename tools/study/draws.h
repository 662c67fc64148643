#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

/// Draws of their own for what a case is, apart from the noise of the run of the same seed.
class Draws {
 public:
  enum class Purpose : std::uint32_t {
    kCase,
    kSlips,
    kErrors,
    kOcclusions,
    kLights,
    kNoise,
    kUnmodelled,
    kStart
  };
  Draws(std::uint64_t seed, Purpose purpose) : engine_(engineFor(seed, purpose)) {}

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double angle() { return between(-kPi, kPi); }
  bool coin() { return between(0.0, 1.0) < 0.5; }
  double gaussian(double stddev) {
    return stddev * std::normal_distribution<double>(0.0, 1.0)(engine_);
  }

 private:
  static std::mt19937_64 engineFor(std::uint64_t seed, Purpose purpose) {
    std::seed_seq words{static_cast<std::uint64_t>(purpose), seed};
    return std::mt19937_64(words);
  }
  std::mt19937_64 engine_;
};

inline Eigen::Vector2d polar(double distance_m, double direction_rad) {
  return distance_m * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
}

}  // namespace bearing_calibration::core
