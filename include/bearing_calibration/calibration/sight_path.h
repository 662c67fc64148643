#pragma once

#include <vector>

#include "bearing_calibration/filter/cartesian_state.h"

namespace bearing_calibration {

/// A sight with the pose at which the odometry says it was made.
struct PosedSight {
  Pose2 first_from_base;  ///< base frame of the record's first sight from that of this one
  double azimuth_rad = 0.0;
  double azimuth_variance_rad2 = 0.0;
  double heading_variance_rad2 = 0.0;  ///< of the odometry, grown since the first sight
  double position_variance_m2 = 0.0;   ///< of the odometry along one axis, grown without headings
};

/// The record with the odometry taken at its word.
std::vector<PosedSight> poseSights(const std::vector<Sight>& sights);

/// Every step-th sight of a record and the last one, with the motion in between carried on.
std::vector<Sight> thinned(const std::vector<Sight>& sights, std::size_t max_sights);

}  // namespace bearing_calibration
