#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/output/visualisation.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/visualisation_markers.h"

namespace bearing_calibration_ros {

/// Publishes ~markers, latched, and while somebody listens to them the start frame on /tf. It hangs
/// on the base, not the base on it: the base may have a parent already (REP 105), and a frame has
/// one only.
class DisplayPublisher {
 public:
  DisplayPublisher(ros::NodeHandle private_node_handle, const CalibrationNodeConfig& config);

  void see(const core::AssociationOutcome& outcome) { visualiser_.see(outcome); }
  /// Draws and publishes what there is now, when the rate allows it.
  void offer(const core::Calibrator& calibrator);
  /// Everything begins anew, the stamps too.
  void restart();

 private:
  void sendStart(const core::BasePlace& place);

  VisualisationStyle style_;
  core::Visualiser visualiser_;
  ros::Publisher publisher_;
  /// None until somebody listens: who wants no transforms gets no topic of them.
  std::unique_ptr<tf2_ros::TransformBroadcaster> tf_broadcaster_;
  ros::SteadyTime last_drawn_;
  core::Stamp last_sent_;
};

}  // namespace bearing_calibration_ros
