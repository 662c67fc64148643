#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "bearing_calibration/output/visualisation.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// The visualisation for RViz, in the namespaces robot, sensor, light, ray, path and state. What
/// the robot carries is in the base frame, what stands in the world in the start frame (REP 105),
/// all locked to their frames, at the sensor's height: one light does not tell heights. Ids stay
/// the same: what is not known is deleted.
visualization_msgs::MarkerArray markersFromVisualisation(const core::Visualisation& visualisation,
                                                         const std::string& state,
                                                         const CalibrationNodeConfig& config);

}  // namespace bearing_calibration_ros
