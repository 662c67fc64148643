#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "bearing_calibration/input/scan_bearings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/sensor_places.h"

namespace bearing_calibration_ros {

/// What bearings are made of, in the order of its names.
enum class BearingSource : std::uint8_t { kPoint, kPose, kPoses, kTf, kScan };

/// Everything that the bearing adapter nodelet needs to know: config/adapter.yaml.
struct AdapterNodeConfig {
  std::string sensor_frame;
  BearingSource source = BearingSource::kPoint;
  double azimuth_stddev_rad = 0.0;
  int light_id = core::kUnknownLight;
  std::map<std::string, int> lights_by_frame;  ///< kTf only
  core::ScanLightConfig scan;

  void declare(core::Parameters& params) {
    constexpr double kLargestId = std::numeric_limits<int>::max();
    params.read("frames/sensor", sensor_frame);
    params.notEmpty("frames/sensor", sensor_frame);
    requireLevel(params, sensor_frame);
    params.choice("bearings/source", {"point", "pose", "poses", "tf", "scan"}, source);
    params.number("bearings/azimuth_stddev", azimuth_stddev_rad, core::plausible::kLeastAngle_rad,
                  core::kPi);
    params.integer("bearings/light_id", light_id, core::kUnknownLight, kLargestId);
    for (const std::string& frame : params.namesIn("tf/lights")) {
      params.integer("tf/lights/" + frame, lights_by_frame[frame], core::kUnknownLight, kLargestId);
    }
    params.that(source != BearingSource::kTf || !lights_by_frame.empty(),
                "tf/lights must give a frame and its light_id, as {tag_1: 1}, with the source tf");
    scan.declare(params);
  }
};

}  // namespace bearing_calibration_ros
