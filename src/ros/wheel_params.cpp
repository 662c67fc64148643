#include "bearing_calibration_ros/wheel_params.h"

#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration_ros {

std::vector<std::string> WheelParams::validate() const {
  core::Requirements require;
  require.that(
      joints.left != joints.right,
      "wheels/left_joint must not be wheels/right_joint, but both are '" + joints.left + "'");
  return require.errors();
}

WheelParams readWheels(ParamReader& params) {
  WheelParams wheels;
  wheels.source = static_cast<WheelSource>(
      params.choice("wheels/source", {"ticks", "joint_states", "separate_ticks"}));
  wheels.joints = {params.text("wheels/left_joint"), params.text("wheels/right_joint")};
  wheels.drive.wheel_separation_m = params.number("wheels/separation");
  wheels.drive.left_wheel_radius_m = params.number("wheels/left_radius");
  wheels.drive.right_wheel_radius_m = params.number("wheels/right_radius");
  wheels.drive.ticks_per_revolution = params.number("wheels/ticks_per_revolution");
  wheels.drive.counter_bits = params.integer("wheels/counter_bits");
  wheels.drive.max_wheel_speed_mps = params.number("wheels/max_speed");
  wheels.noise.independent_k_m = params.number("wheels/noise_independent");
  wheels.noise.common_k_m = params.number("wheels/noise_common");
  wheels.max_apart_s = params.number("wheels/max_apart");
  wheels.history_s = params.number("wheels/history");
  return wheels;
}

}  // namespace bearing_calibration_ros
