#pragma once

#include <bearing_calibration/DetectionThresholdsConfig.h>
#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>

#include <functional>
#include <string>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// The detector's thresholds by dynamic_reconfigure, below ~thresholds. What the detector cannot
/// work with is refused: the thresholds before it stay, and `refusal` tells why.
class ThresholdServer {
 public:
  /// Takes the changed thresholds over; they have been validated.
  using Apply = std::function<void(const core::DetectorConfig&)>;
  /// Is told of each change, or of its refusal.
  using Say = std::function<void(bool is_refused, const std::string& sentence)>;

  /// @param detector  what the thresholds are when it begins, and all that they belong to
  ThresholdServer(const ros::NodeHandle& private_node_handle, const core::DetectorConfig& detector,
                  Apply apply, Say say);

 private:
  using Config = msg::DetectionThresholdsConfig;
  void onChange(Config& config);

  core::DetectorConfig detector_;
  Apply apply_;
  Say say_;
  bool has_begun_ = false;
  dynamic_reconfigure::Server<Config> server_;
};

}  // namespace bearing_calibration_ros
