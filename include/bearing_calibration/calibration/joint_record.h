#pragma once

#include <cstddef>
#include <vector>

#include "bearing_calibration/noise/noise_levels.h"
#include "bearing_calibration/record/lights_record.h"
#include "bearing_calibration/solve/batch_estimator.h"

namespace bearing_calibration::core {

/// What one light by itself said of the mount the last time that a fit of its record settled.
struct LandmarkSolution {
  std::vector<Stamp> stamps;  ///< of the record's observations
  BatchEstimate fit;          ///< over them
  StateEstimate average;  ///< with its rivals (see averageOverSlips) and all levels of noise, at
                          ///< the last observation
  NoiseLevels noise;      ///< against the stated one
};

/// The answer whose mount is known best.
const LandmarkSolution& surestOf(const std::vector<const LandmarkSolution*>& answers);

/// The observations of some lights in the order of time, each with its place in `lights` as its
/// number. An image that shows none of them only moves the base.
std::vector<Observation> observationsOf(const std::vector<LightsImage>& images,
                                        const std::vector<std::size_t>& lights);

/// What the base has moved after the last of these observations: the last images may show none of
/// their lights.
OdometryIncrement motionAfter(const std::vector<Observation>& observations,
                              const std::vector<LightsImage>& images);

/// The same observations with the noise that was found: each light's bearings with that of its own
/// answer, the wheels with the surest one's.
/// @param observations  their light i is the one of answers[i]
std::vector<Observation> withNoise(std::vector<Observation> observations,
                                   const std::vector<const LandmarkSolution*>& answers);

/// Images to which the motion is given up, of all that any of the answers gave up.
std::vector<std::size_t> slipsOf(const std::vector<Observation>& observations,
                                 const std::vector<const LandmarkSolution*>& answers);

/// Sets aside what each light's own fit has left out.
void setOutliersAside(const std::vector<Observation>& observations,
                      const std::vector<const LandmarkSolution*>& answers, RecordTrack* track);

}  // namespace bearing_calibration::core
