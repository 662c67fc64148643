#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/filter/state.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// One bearing of a light with the base's motion since the bearing before it.
struct Observation {
  Stamp stamp;
  OdometryIncrement motion;  ///< from the previous observation's moment to this one's
  double azimuth_rad = 0.0;
  double azimuth_variance_rad2 = 0.0;
  OdometryWindow nearby;  ///< around the stamp; no motion where nobody asks for the time offset
  std::optional<Elevation> elevation = std::nullopt;  ///< where the sensor has one
  int light = 0;                                      ///< which one of a record's lights
  /// Standard deviation of the point that is seen, across the line of sight, from the light's
  /// place: no light is a point.
  double light_size_m = 0.0;
};

/// Variance of an azimuth [rad^2] of a light at this range.
inline double azimuthVarianceAt(const Observation& observation, double range_m) {
  const double beside_rad = observation.light_size_m / range_m;
  return observation.azimuth_variance_rad2 + beside_rad * beside_rad;
}

inline double secondsBetween(const Observation& before, const Observation& after) {
  return secondsFromDuration(after.stamp - before.stamp);
}

/// Residual of an observation [rad]: measured minus expected.
/// @param state  its light with the mount, at its stamp
double residualOf(const Observation& observation, const Vector5& state, const ErrorVector& errors);

/// The same of its elevation; none where it has none.
std::optional<double> elevationResidualOf(const Observation& observation, const Vector5& state,
                                          const ErrorVector& errors);

/// The pose of the base at the moment when an observation was really made, in the base frame at its
/// stamp.
Pose2 stampFromMoment(const Observation& observation, const ErrorVector& errors);

/// The record of a robot without errors that sees the same: motions put right, bearings at their
/// own moments. (What bends a bearing, mirror and tilt, is left in.)
std::vector<Observation> withoutErrors(const std::vector<Observation>& observations,
                                       const ErrorVector& errors);

}  // namespace bearing_calibration::core
