#include "bearing_calibration_ros/prediction_publisher.h"

#include <bearing_calibration/PredictedBearing.h>

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {

PredictionPublisher::PredictionPublisher(ros::NodeHandle private_node_handle,
                                         const CalibrationNodeConfig& config)
    : sensor_frame_(config.frames.sensor),
      max_rate_hz_(config.output.prediction_rate_hz),
      latency_(core::durationFromSeconds(config.calibrator.bearings.latency_s)),
      publisher_(private_node_handle.advertise<msg::PredictedBearing>("predicted_bearing", 1)) {}

void PredictionPublisher::offer(const core::Calibrator& calibrator, core::Stamp newest_wheels) {
  const bool is_due = core::secondsFromDuration(newest_wheels - last_) * max_rate_hz_ >= 1.0;
  if (!is_due || publisher_.getNumSubscribers() == 0) return;
  const auto prediction = calibrator.predictBearing(newest_wheels + latency_);
  if (!prediction) return;
  last_ = newest_wheels;
  publisher_.publish(messageFromPrediction(*prediction, sensor_frame_));
}

}  // namespace bearing_calibration_ros
