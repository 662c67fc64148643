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

  RandomStream(std::uint64_t seed, Purpose purpose, std::uint64_t number = 0)
      : engine_(engineFor(seed, purpose, number)) {}

  double gaussian() { return gaussian_(engine_); }  ///< mean 0, standard deviation 1
  double uniform() { return uniform_(engine_); }    ///< in [0, 1)
  bool happens(double probability) { return uniform() < probability; }

 private:
  static std::mt19937_64 engineFor(std::uint64_t seed, Purpose purpose, std::uint64_t number) {
    constexpr unsigned kWordBits = 32;
    std::seed_seq words{static_cast<std::uint32_t>(seed),
                        static_cast<std::uint32_t>(seed >> kWordBits),
                        static_cast<std::uint32_t>(purpose), static_cast<std::uint32_t>(number),
                        static_cast<std::uint32_t>(number >> kWordBits)};
    return std::mt19937_64(words);
  }

  std::mt19937_64 engine_;
  std::normal_distribution<double> gaussian_;
  std::uniform_real_distribution<double> uniform_;
};

}  // namespace bearing_calibration::core
