#include "bearing_calibration/input/point_bearing.h"

#include <cmath>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

const char* whyNoPoint(const Eigen::Vector3d& point_m) {
  if (!point_m.allFinite()) return "point not finite";
  return point_m.norm() < plausible::kShortest_m ? "point at the origin" : nullptr;
}

const char* whyNoAzimuth(const Eigen::Vector3d& point_in_sensor_m) {
  if (!point_in_sensor_m.allFinite()) return "point not finite";
  return point_in_sensor_m.head<2>().norm() < plausible::kShortest_m
             ? "point on the sensor's z axis"
             : nullptr;
}

Bearing bearingOfPoint(const Eigen::Vector3d& point_in_sensor_m, double stddev_rad) {
  Bearing bearing;
  bearing.azimuth_rad = std::atan2(point_in_sensor_m.y(), point_in_sensor_m.x());
  bearing.azimuth_variance_rad2 = stddev_rad * stddev_rad;
  bearing.elevation_rad = std::atan2(point_in_sensor_m.z(), point_in_sensor_m.head<2>().norm());
  bearing.elevation_variance_rad2 = bearing.azimuth_variance_rad2;
  return bearing;
}

}  // namespace bearing_calibration::core
