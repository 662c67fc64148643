#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/planning/hop.h"

namespace bearing_calibration {

/// What a robot's sensors will tell on its way, as the filter models it.
struct SensingModel {
  WheelNoise wheel_noise;
  double bearing_stddev_rad = 0.0;  ///< of one bearing
  double bearing_rate_hz = 0.0;

  std::vector<std::string> validate() const;
};

/// The estimate after a motion of the base (doc/model.md, eqs. 5 and 7).
CartesianEstimate movedBy(const OdometryIncrement& motion, const CartesianEstimate& estimate);

/// The estimate as the filter will have it after a hop: the mean moves as planned, the covariance
/// grows by the wheels' noise and shrinks by the bearings (doc/model.md, eqs. 5 to 8). Bearings are
/// taken together over steps of at most a quarter of a second.
CartesianEstimate predictAfter(const Hop& hop, const CartesianEstimate& estimate,
                               const WheelLimits& limits, const SensingModel& sensing);

/// How near a hop comes to the light at most, by what is known before it: the least distance from
/// the base's centre to the light minus `sigmas` standard deviations in that direction [m].
double lightClearance(const Hop& hop, const CartesianEstimate& estimate, double sigmas);

}  // namespace bearing_calibration
