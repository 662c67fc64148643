#pragma once

#include <cstdint>
#include <random>

namespace bearing_calibration::core {

/// Reproducible random numbers. Streams of one seed but of different purposes are independent, so
/// that switching one kind of noise on or off leaves the draws of all others as they were.
class RandomStream {
 public:
  enum class Purpose : std::uint32_t {
    kTrajectory,
    kEncoders,
    kBearings,
    kFaults,
    kImage,
    kElevations
  };

  RandomStream(std::uint64_t seed, Purpose purpose) {
    constexpr unsigned kWordBits = 32;
    std::seed_seq words{static_cast<std::uint32_t>(seed),
                        static_cast<std::uint32_t>(seed >> kWordBits),
                        static_cast<std::uint32_t>(purpose), 0U, 0U};
    engine_.seed(words);
  }

  double gaussian() { return gaussian_(engine_); }  ///< mean 0, standard deviation 1
  double uniform() { return uniform_(engine_); }    ///< in [0, 1)
  bool happens(double probability) { return uniform() < probability; }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> gaussian_;
  std::uniform_real_distribution<double> uniform_;
};

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
