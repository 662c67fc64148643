#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "bearing_calibration/vision/blink_identifier.h"
#include "bearing_calibration/vision/colour_identifier.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/search_region.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/sensor_places.h"

namespace bearing_calibration_ros {

/// Everything that the light detection nodelet needs to know: config/detection.yaml.
struct DetectionNodeConfig {
  std::string sensor_frame;
  bool camera_info_required = false;
  int image_queue = 0;        ///< images that wait while one is searched
  std::string optics_folder;  ///< where learnt optics are saved; empty: nowhere
  core::DetectorConfig detector;
  core::ShutterConfig shutter;
  core::SearchConfig search;
  core::BlinkConfig blink;
  core::ColourConfig colour;
  /// Of so many images one is searched whole, so that a wrong prediction does not feed itself.
  int full_scan_every = 0;

  void declare(core::Parameters& params) {
    constexpr int kLongestQueue = 1000;  // of 640x480: 300 MB
    params.read("frames/sensor", sensor_frame);
    params.notEmpty("frames/sensor", sensor_frame);
    const std::vector<std::string> frames = params.namesIn("frames");
    if (std::count(frames.begin(), frames.end(), "base") > 0) {
      std::string of_the_calibration;  // which reads the same file of a robot
      params.read("frames/base", of_the_calibration);
    }
    params.read("camera_info/required", camera_info_required);
    params.integer("images/queue", image_queue, 1, kLongestQueue);
    params.read("optics/folder", optics_folder);
    optics_folder = expandHome(optics_folder);
    detector.declare(params);
    if (detector.mirror_kind == core::MirrorKind::kNone) requireLevel(params, sensor_frame);
    shutter.declare(params);
    search.declare(params);
    blink.declare(params);
    colour.declare(params);
    params.that(!(blink.use && colour.use),
                "blink/use and colour/use cannot both be set: one of them names the light");
    params.integer("prediction/full_scan_every", full_scan_every, 1, core::plausible::kMostOfAKind);
  }
};

}  // namespace bearing_calibration_ros
