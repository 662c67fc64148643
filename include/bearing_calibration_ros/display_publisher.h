#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>

#include "bearing_calibration/calibration/calibration_sketch.h"
#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/sketch_markers.h"

namespace bearing_calibration_ros {

/// Publishes ~markers, latched, and while somebody listens to them the start frame on /tf. It hangs
/// on the base, not the base on it: the base may have a parent already (REP 105), and a frame has
/// one only.
class DisplayPublisher {
 public:
  DisplayPublisher(ros::NodeHandle private_node_handle, const CalibrationNodeConfig& config);

  void see(const bearing_calibration::Look& look) { sketcher_.see(look); }
  /// Draws and publishes what there is now, when the rate allows it.
  void offer(const bearing_calibration::Calibrator& calibrator);
  /// Everything begins anew, the stamps too.
  void restart();

 private:
  void sendStart(const bearing_calibration::BasePlace& place);

  SketchStyle style_;
  bearing_calibration::CalibrationSketcher sketcher_;
  ros::Publisher publisher_;
  /// None until somebody listens: who wants no transforms gets no topic of them.
  std::unique_ptr<tf2_ros::TransformBroadcaster> tf_broadcaster_;
  ros::SteadyTime last_drawn_;
  bearing_calibration::Stamp last_sent_;
};

}  // namespace bearing_calibration_ros
