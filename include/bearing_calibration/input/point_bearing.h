#pragma once

#include <Eigen/Core>

#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// Why a measured point is none, as a name for counters; null for one that is: not finite, or at
/// the origin of the frame that it is measured in.
const char* whyNoPoint(const Eigen::Vector3d& point_m);

/// Why a point has no azimuth, in the same way: too far for numbers, or on the sensor's z axis.
const char* whyNoAzimuth(const Eigen::Vector3d& point_in_sensor_m);

/// Azimuth and elevation of a point, each with this standard deviation.
Bearing bearingOfPoint(const Eigen::Vector3d& point_in_sensor_m, double stddev_rad);

}  // namespace bearing_calibration::core
