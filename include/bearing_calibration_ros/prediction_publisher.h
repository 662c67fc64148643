#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Publishes ~predicted_bearing: where the sensor should see the light, by the newest wheel
/// readings.
class PredictionPublisher {
 public:
  PredictionPublisher(ros::NodeHandle private_node_handle, const CalibrationNodeConfig& config);

  /// Predicts for the moment of the newest wheel readings, when someone listens, there is an
  /// estimate, and the rate allows it.
  void offer(const core::Calibrator& calibrator, core::Stamp newest_wheels);

  /// The stamps begin anew.
  void restart() { last_ = {}; }

 private:
  std::string sensor_frame_;
  double max_rate_hz_;
  core::Duration latency_;  ///< of the sensor's stamps
  ros::Publisher publisher_;
  core::Stamp last_;  ///< of the wheel readings
};

}  // namespace bearing_calibration_ros
