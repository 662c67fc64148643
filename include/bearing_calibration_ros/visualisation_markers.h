#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "bearing_calibration/output/visualisation.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// What the markers need to know beside the visualisation.
struct VisualisationStyle {
  std::string base_frame;
  std::string start_frame;
  double wheel_separation_m = 0.0;
  double wheel_radius_m = 0.0;
  double sensor_height_m = 0.0;  ///< of everything but the robot: one light does not tell heights
  int most_lights = 1;           ///< that there are markers for
};

VisualisationStyle visualisationStyleFrom(const CalibrationNodeConfig& config);

/// The visualisation for RViz, in the namespaces robot, sensor, light, ray, path and state. What
/// the robot carries is in the base frame, what stands in the world in the start frame (REP 105),
/// all locked to their frames. Ids stay the same: what is not known is deleted.
visualization_msgs::MarkerArray markersFromVisualisation(const core::Visualisation& visualisation,
                                                         const std::string& state,
                                                         const VisualisationStyle& style);

}  // namespace bearing_calibration_ros
