#pragma once

#include <vector>

#include "bearing_calibration/calibration/joint_record.h"
#include "bearing_calibration/record/lights_record.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// Adds lights until there are `count`: in random directions from where the base starts, as far
/// from it as the first one is, give or take a quarter, and not in its way.
void addLights(SimulatedCase& simulated, int count, std::uint64_t seed);

/// Puts the first light so high over the sensor, the last one as far below it, the others evenly
/// between them.
void spreadHeights(SimulatedCase& simulated, double highest_m);

/// The first `count` images of a run that show any light, each light by its number.
std::vector<LightsImage> imagesOf(const ObservationRun& run, std::size_t count);

/// The observations of all lights in these images.
std::vector<Observation> allObservationsOf(const SimulatedCase& simulated,
                                           const std::vector<LightsImage>& images);

/// The true path at all observations of the run's first `images`: where a fit of them ends that
/// begins there is what all others are held to.
RecordTrack trueTrack(const SimulatedCase& simulated, const ObservationRun& run,
                      const std::vector<LightsImage>& images);

/// Covariance of mount, errors and lights that no unbiased estimator can beat (see
/// cramerRaoBound()).
StateEstimate lightsBound(const SimulatedCase& simulated, const ObservationRun& run,
                          std::size_t count);

}  // namespace bearing_calibration::core
