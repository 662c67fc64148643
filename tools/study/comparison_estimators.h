#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/study/monte_carlo_trials.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// The data of one run, the same for all estimators.
struct ComparedRun {
  SimulatedCase simulated;
  std::uint64_t seed = 0;
  ObservationRun truth;
  std::vector<Observation> observations;  ///< with the noise that is stated
};

/// @param simulated  its robot's seed is that of the noise
/// @param seed  of the starts that estimators are given
ComparedRun comparedRun(const SimulatedCase& simulated, std::uint64_t seed);

/// One of the estimators that are compared, at the end of a run. It is sure (Snapshot::claims) when
/// its standard deviations meet the calibrator's targets, the calibrator when it is CONVERGED.
struct ComparedEstimator {
  std::string name;
  std::string given;  ///< what it needs beside bearings, wheels and their stated noise
  Snapshot (*run)(const ComparedRun& run);
};

/// This package's calibrator with its default configuration, which estimates errors and noise.
Snapshot runCalibrator(const ComparedRun& run);
/// The paper's EKF from a start that is uniform within 10 % and 10 degrees of the truth.
Snapshot runPaperFilter(const ComparedRun& run);
/// The same within 50 % and 60 degrees.
Snapshot runPaperFilterFromFar(const ComparedRun& run);
/// EKFs from 36 starts that the first bearing allows: 3 ranges, 12 yaws. The one whose innovations
/// are the most likely speaks.
Snapshot runFilterBank(const ComparedRun& run);
/// Least squares over mount, light and path by Ceres, from the paper filter's good start.
Snapshot runCeres(const ComparedRun& run);
/// An EKF of the mount that knows where the light is from where the robot starts, from the mount of
/// the paper filter's good start.
Snapshot runKnownLight(const ComparedRun& run);

/// All of them; the second is the plain EKF that CPU times are compared with.
const std::vector<ComparedEstimator>& comparedEstimators();
inline constexpr std::size_t kPlainFilter = 1;

}  // namespace bearing_calibration::core
