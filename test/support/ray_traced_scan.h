#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <vector>

#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/input/scan_bearings.h"

namespace bearing_calibration::core::testing {

struct Post {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.05;
  float intensity = 10.0F;
};

inline Eigen::Vector2d placeAt(double distance_m, double direction_rad) {
  return {distance_m * std::cos(direction_rad), distance_m * std::sin(direction_rad)};
}

/// A whole turn in 0.1 s, counter-clockwise from -pi, in a round room of 8 m: each ray meets the
/// nearest of the posts (a line and a circle).
/// @param world_from_scanner  at a time [s] after the first ray; the posts are in the world
inline LaserScan tracedScan(
    const std::vector<Post>& posts, Stamp stamp = stampFromSeconds(100.0),
    const std::function<Pose2(double)>& world_from_scanner = [](double) { return Pose2(); }) {
  constexpr int kRays = 720;
  constexpr double kTurn_s = 0.1;
  constexpr float kWall_m = 8.0F;
  LaserScan scan;
  scan.stamp = stamp;
  scan.ray_period_s = kTurn_s / kRays;
  scan.first_ray_rad = -kPi;
  scan.ray_spacing_rad = 2.0 * kPi / kRays;
  scan.least_range_m = 0.1;
  scan.most_range_m = 30.0;
  for (int i = 0; i < kRays; ++i) {
    const Pose2 scanner_from_world = world_from_scanner(i * scan.ray_period_s).inverse();
    const Eigen::Vector2d ray = placeAt(1.0, scan.first_ray_rad + i * scan.ray_spacing_rad);
    scan.ranges_m.push_back(kWall_m);
    scan.intensities.push_back(0.0F);
    for (const Post& post : posts) {
      const Eigen::Vector2d centre = scanner_from_world * post.centre_m;
      const double along_m = centre.dot(ray);
      const double aside2 = centre.squaredNorm() - along_m * along_m;
      const double depth2 = post.radius_m * post.radius_m - aside2;
      if (along_m < 0.0 || depth2 < 0.0) continue;
      const auto range_m = static_cast<float>(along_m - std::sqrt(depth2));
      if (range_m >= scan.ranges_m.back()) continue;
      scan.ranges_m.back() = range_m;
      scan.intensities.back() = post.intensity;
    }
  }
  return scan;
}

}  // namespace bearing_calibration::core::testing
