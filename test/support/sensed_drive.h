#pragma once

#include <functional>
#include <optional>
#include <random>

#include "bearing_calibration/optics/bearing.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core::testing {

/// A robot's true motion in steps of 0.01 s, from which a sensor's messages are made.
class SensedDrive {
 public:
  explicit SensedDrive(std::uint64_t seed);

  /// Between two steps on the chord of its arc, 4e-6 m beside it at most.
  Pose2 worldFromSensor(double time_s) const;

  SimulatedCase simulated;
  SimulatedRecord steps;
};

/// What a sensor says of the light at the world's origin, at `time_s` of the drive.
using Sensed = std::function<BearingSet(const SensedDrive&, Stamp, double time_s, std::mt19937*,
                                        const std::optional<BearingPrediction>&)>;

/// 20 drives with ten messages a second: each converges with the truth inside of its covariance
/// (chi-square below 25, by chance once in 65000), all covariances together are as large as the
/// errors (the band of 99 %), and the standard deviations at most 1.3 times those of the bound.
void expectHonestAndNearTheBound(const Sensed& sensed);

}  // namespace bearing_calibration::core::testing
