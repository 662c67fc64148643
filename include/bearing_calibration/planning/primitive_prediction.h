#pragma once

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/planning/motion_primitive.h"

namespace bearing_calibration::core {

/// What a robot's sensors will tell on its way, as the filter models it.
struct SensingModel {
  WheelNoise wheel_noise;
  double bearing_stddev_rad = 0.0;  ///< of one bearing
  double bearing_rate_hz = 0.0;

  void declare(Parameters& params);
};

/// The estimate after a motion of the base (doc/model.md, eqs. 5 and 7, 17 and 18).
RobotEstimate movedBy(const OdometryIncrement& motion, const RobotEstimate& estimate);

/// The estimate as the filter will have it after a primitive: the mean moves as planned, the
/// covariance grows by the wheels' noise and shrinks by the bearings (doc/model.md, eqs. 5 to 8, 16
/// to 18). Bearings are taken together over steps of at most a quarter of a second. Of the robot's
/// errors, those of clock and wheels count: an unequal wheel bends a straight way as a light's
/// parallax would, so that who does not doubt the wheels expects of such ways what they cannot
/// teach.
RobotEstimate predictAfter(const MotionPrimitive& primitive, const RobotEstimate& estimate,
                           const WheelLimits& limits, const SensingModel& sensing);

/// How near a primitive comes to the light at most, by what is known before it: the least distance
/// from the base's centre to the light minus `sigmas` standard deviations in that direction [m].
double lightClearance(const MotionPrimitive& primitive, const CartesianEstimate& estimate,
                      double sigmas);

}  // namespace bearing_calibration::core
