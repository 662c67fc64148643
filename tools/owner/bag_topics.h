#pragma once

#include <rosbag/view.h>

#include <string>
#include <vector>

#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration::core {

/// Topics to read; an empty name is to be found by its type.
struct BagTopics {
  std::string wheels;
  std::string right_wheel;  ///< only of separate ticks; `wheels` is the left one then
  std::string bearings;
  std::string images;             ///< only where the bearings are to be found in images
  std::string camera_info;        ///< beside the images; empty where there is none
  std::string static_transforms;  ///< the same
  std::string plan;  ///< what a drive expects of its way ahead; empty where there is none

  const std::string& observations() const { return images.empty() ? bearings : images; }
  std::vector<std::string> names() const;
};

/// Completes the names from what a bag holds. Bearings go before images.
/// @param wanted  names from the command line, with or without a slash in front
/// @throws std::runtime_error that lists the bag's topics when one is missing or there are several
BagTopics findTopics(rosbag::View& whole_bag, const BagTopics& wanted,
                     bearing_calibration_ros::WheelSource source);

}  // namespace bearing_calibration::core
