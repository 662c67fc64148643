#include "bearing_calibration_ros/detection_params.h"

namespace bearing_calibration_ros {

void DetectionNodeConfig::declare(core::Parameters& params) {
  constexpr int kLongestQueue = 1000;  // of 640x480: 300 MB
  params.read("frames/sensor", sensor_frame);
  params.notEmpty("frames/sensor", sensor_frame);
  params.read("camera_info/required", camera_info_required);
  params.integer("images/queue", image_queue, 1, kLongestQueue);
  detector.declare(params);
  shutter.declare(params);
  search.declare(params);
  blink.declare(params);
  colour.declare(params);
  params.that(!(blink.use && colour.use),
              "blink/use and colour/use cannot both be set: one of them names the light");
  params.integer("prediction/full_scan_every", full_scan_every, 1, core::plausible::kMostOfAKind);
}

}  // namespace bearing_calibration_ros
