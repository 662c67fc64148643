#pragma once

#include <random>

namespace bearing_calibration::core {

struct Interval {
  double low = 0.0;
  double high = 0.0;
};

struct CountRange {
  int least = 0;
  int most = 0;
};

/// Draws what a scene holds. One seed is one scene.
using SceneRandom = std::mt19937_64;

inline double drawBetween(const Interval& interval, SceneRandom* random) {
  return std::uniform_real_distribution<double>(interval.low, interval.high)(*random);
}

inline int drawCount(const CountRange& range, SceneRandom* random) {
  return std::uniform_int_distribution<int>(range.least, range.most)(*random);
}

}  // namespace bearing_calibration::core
