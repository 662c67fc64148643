#include "fuzz/simulated_world.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::fuzz {

SimulatedWorld::SimulatedWorld(const core::DriveGeometry& drive, std::uint32_t seed)
    : drive_(drive), random_(seed) {}

void SimulatedWorld::roll(const core::WheelDisplacement& wheels, core::Duration time) {
  world_from_base_ =
      world_from_base_ * core::arcFromWheels(wheels, drive_.wheel_separation_m).start_from_end;
  left_m_ += wheels.left_m;
  right_m_ += wheels.right_m;
  now_ += time;
}

std::int64_t SimulatedWorld::leftTicks() const {
  return std::llround(left_m_ / drive_.leftMetersPerTick());
}

std::int64_t SimulatedWorld::rightTicks() const {
  return std::llround(right_m_ / drive_.rightMetersPerTick());
}

std::vector<core::Bearing> SimulatedWorld::bearings(double stddev_rad) {
  const core::Pose2 sensor_from_world = (world_from_base_ * base_from_sensor_).inverse();
  std::vector<core::Bearing> bearings;
  for (const Eigen::Vector2d& light_m : lights_m_) {
    const Eigen::Vector2d seen_m = sensor_from_world * light_m;
    core::Bearing bearing;
    bearing.azimuth_rad =
        core::wrapAngle(std::atan2(seen_m.y(), seen_m.x()) + stddev_rad * gaussian_(random_));
    bearing.azimuth_variance_rad2 = stddev_rad * stddev_rad;
    bearing.light_id = static_cast<std::int32_t>(bearings.size());
    bearings.push_back(bearing);
  }
  return bearings;
}

}  // namespace bearing_calibration::fuzz
