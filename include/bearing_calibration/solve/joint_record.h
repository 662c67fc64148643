#pragma once

#include <cstddef>
#include <vector>

#include "bearing_calibration/record/lights_record.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/landmark_solution.h"

namespace bearing_calibration::core {

/// The observations of some lights in the order of time, each with its place in `lights` as its
/// number. An image that shows none of them only moves the base.
std::vector<Observation> observationsOf(const std::vector<LightsImage>& images,
                                        const std::vector<std::size_t>& lights);

/// The path that ends with the lights and the mount of `end` and is made by the motions with their
/// errors.
/// @param motion_errors  for each observation, of the motion to its image (x, y, yaw): true minus
/// measured
RecordPath pathTo(const std::vector<Observation>& observations, const RecordPath& end,
                  const std::vector<Eigen::Vector3d>& motion_errors);

/// Where a fit of several lights begins, and what it supposes of slips.
struct JointStart {
  RecordTrack track;
  SlipHypothesis slips;
};

/// From what each light's own calibration has decided of its observations: outliers are set aside,
/// motions that any of them gave up are given up, and the path is that of the surest one.
/// @param observations  their light i is the one of answers[i]
JointStart startFromAnswers(const std::vector<Observation>& observations,
                            const std::vector<const LandmarkSolution*>& answers);

/// The same observations with the noise that was found: each light's bearings with that of its own
/// answer, the wheels with the surest one's.
std::vector<Observation> withNoise(std::vector<Observation> observations,
                                   const std::vector<const LandmarkSolution*>& answers);

/// The answer whose mount is known best.
const LandmarkSolution& surestOf(const std::vector<const LandmarkSolution*>& answers);

}  // namespace bearing_calibration::core
