#include "bearing_calibration_ros/wheel_params.h"

namespace bearing_calibration_ros {

void WheelInput::declare(core::Parameters& params) {
  params.choice("wheels/source", {"ticks", "joint_states", "separate_ticks"}, source);
  params.read("wheels/left_joint", joints.left);
  params.read("wheels/right_joint", joints.right);
  params.that(
      joints.left != joints.right,
      "wheels/left_joint must not be wheels/right_joint, but both are '" + joints.left + "'");
}

}  // namespace bearing_calibration_ros
