#include "bearing_calibration/simulation/shutter.h"

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

void Shutter::declare(Parameters& params) {
  constexpr double kLongestExposure_s = 1.0;
  constexpr double kLongestRow_s = 1e-3;  // a second for a thousand rows
  params.number("camera/exposure_time", exposure_s, 0.0, kLongestExposure_s);
  params.number("camera/row_time", row_time_s, 0.0, kLongestRow_s);
}

// The way points along the mean heading of its time, which is right to the second order.
Pose2 SensorMotion::poseAt(double time_s) const {
  const double turn_rad = turn_radps * time_s;
  return world_from_sensor * Pose2{rotation2(0.5 * turn_rad) * velocity_mps * time_s, turn_rad};
}

SensorMotion motionBetween(const Pose2& world_from_start, const Pose2& world_from_end,
                           double duration_s) {
  const Pose2 start_from_end = world_from_start.inverse() * world_from_end;
  const double turn_rad = start_from_end.yaw_rad;
  return {world_from_start, rotation2(-0.5 * turn_rad) * start_from_end.position_m / duration_s,
          turn_rad / duration_s};
}

}  // namespace bearing_calibration::core
