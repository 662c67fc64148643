#pragma once

#include <vector>

#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core {

/// An observation with the pose at which the odometry says it was made.
struct PosedObservation {
  Pose2 first_from_base;  ///< base frame of the record's first observation from that of this one
  double azimuth_rad = 0.0;
  double azimuth_variance_rad2 = 0.0;
  double heading_variance_rad2 = 0.0;  ///< of the odometry, grown since the first observation
  double position_variance_m2 = 0.0;   ///< of the odometry along one axis, grown without headings
};

/// The record with the odometry taken at its word.
std::vector<PosedObservation> poseObservations(const std::vector<Observation>& observations);

/// Every step-th observation of a record and the last one, with the motion in between carried on.
std::vector<Observation> thinned(const std::vector<Observation>& observations,
                                 std::size_t max_observations);

}  // namespace bearing_calibration::core
