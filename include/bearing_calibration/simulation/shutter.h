#pragma once

#include <Eigen/Core>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

/// When the rows of an image collect light. Time 0 is the middle of the first row's exposure.
struct Shutter {
  double exposure_s = 0.0;  ///< of each row; 0 freezes every motion
  double row_time_s = 0.0;  ///< from one row's exposure to the next one's; 0 is a global shutter

  void declare(Parameters& params);
  bool isInstant() const { return exposure_s <= 0.0 && row_time_s <= 0.0; }
};

/// How the sensor moves during an exposure: steadily.
struct SensorMotion {
  Pose2 world_from_sensor;                                 ///< at time 0
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< in the sensor frame
  double turn_radps = 0.0;

  Pose2 poseAt(double time_s) const;
};

/// The steady motion from one pose to the next within `duration_s`.
SensorMotion motionBetween(const Pose2& world_from_start, const Pose2& world_from_end,
                           double duration_s);

}  // namespace bearing_calibration::core
