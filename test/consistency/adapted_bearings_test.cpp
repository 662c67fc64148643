// What the bearing adapter makes of poses and of laser scans calibrates a mount as well as the
// bound allows, and says how well.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "bearing_calibration/input/point_bearing.h"
#include "bearing_calibration/input/scan_bearings.h"
#include "support/ray_traced_scan.h"
#include "support/sensed_drive.h"

namespace bearing_calibration::core {
namespace {

using testing::expectHonestAndNearTheBound;
using testing::Post;
using testing::SensedDrive;

const double kStddev_rad = radiansFromDegrees(0.5);

/// A marker 0.4 m above the sensor, in the optical frame of a camera that looks along the sensor's
/// x axis (REP 103: x to the right, y down, z ahead).
BearingSet fromPose(const SensedDrive& drive, Stamp stamp, double time_s, std::mt19937* random,
                    const std::optional<BearingPrediction>&) {
  std::normal_distribution<double> gaussian;
  const Eigen::Vector2d place = drive.worldFromSensor(time_s).inverse() * Eigen::Vector2d::Zero();
  const double azimuth = std::atan2(place.y(), place.x()) + kStddev_rad * gaussian(*random);
  const double distance_m = place.norm() * (1.0 + 0.05 * gaussian(*random));
  const Eigen::Vector3d marker_in_optical(-distance_m * std::sin(azimuth), -0.4,
                                          distance_m * std::cos(azimuth));
  Eigen::Isometry3d sensor_from_optical = Eigen::Isometry3d::Identity();
  sensor_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {stamp, {bearingOfPoint(sensor_from_optical * marker_in_optical, kStddev_rad)}};
}

/// A post at the origin, and others at `clutter`, by a scanner whose scans are turned by some noise
/// each.
BearingSet fromScan(const std::vector<Post>& posts, const SensedDrive& drive, Stamp stamp,
                    double time_s, std::mt19937* random,
                    const std::optional<BearingPrediction>& prediction) {
  std::normal_distribution<double> gaussian;
  const double turned_rad = kStddev_rad * gaussian(*random);
  LaserScan scan = testing::tracedScan(posts, stamp, [&](double after_s) {
    Pose2 world_from_sensor = drive.worldFromSensor(time_s + after_s);
    world_from_sensor.yaw_rad -= turned_rad;
    return world_from_sensor;
  });
  constexpr float kRangeStddev_m = 0.01F;
  for (float& range : scan.ranges_m)
    range += kRangeStddev_m * static_cast<float>(gaussian(*random));
  return bearingsInScan(scan, {0.0, 0.2, 0.03, 0.2}, Eigen::Isometry3d::Identity(), kStddev_rad,
                        prediction);
}

TEST(AdaptedBearings, OfPosesAreAsGoodAsTheySay) { expectHonestAndNearTheBound(fromPose); }

TEST(AdaptedBearings, OfAPostInScansAreAsGoodAsTheySay) {
  expectHonestAndNearTheBound([](auto&&... how) { return fromScan({Post()}, how...); });
}

}  // namespace
}  // namespace bearing_calibration::core
