#include "bearing_calibration_ros/threshold_server.h"

#include <cstdint>
#include <utility>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {
namespace {

using Config = msg::DetectionThresholdsConfig;

Config configFrom(const core::DetectorConfig& detector) {
  Config config = Config::__getDefault__();
  config.min_contrast = detector.threshold.min_contrast_levels;
  config.spreads = detector.threshold.spreads;
  config.min_pixels = detector.gates.min_pixels;
  config.max_pixels = detector.gates.max_pixels;
  config.min_probability = detector.gates.min_probability;
  return config;
}

core::DetectorConfig detectorWith(const Config& config, core::DetectorConfig detector) {
  detector.threshold.min_contrast_levels = config.min_contrast;
  detector.threshold.spreads = config.spreads;
  detector.gates.min_pixels = config.min_pixels;
  detector.gates.max_pixels = config.max_pixels;
  detector.gates.min_probability = config.min_probability;
  return detector;
}

}  // namespace

ThresholdServer::ThresholdServer(const ros::NodeHandle& private_node_handle,
                                 const core::DetectorConfig& detector, Apply apply, Say say)
    : detector_(detector),
      apply_(std::move(apply)),
      say_(std::move(say)),
      server_(ros::NodeHandle(private_node_handle, "thresholds")) {
  server_.setConfigDefault(configFrom(detector_));
  server_.setCallback([this](Config& config, std::uint32_t) { onChange(config); });
}

void ThresholdServer::onChange(Config& config) {
  if (!has_begun_) {  // what an earlier run left on the parameter server gives way
    has_begun_ = true;
    config = configFrom(detector_);
    return;
  }
  const std::string refusal = thrownBy([&] {
    detector_ = core::validated(detectorWith(config, detector_));
    apply_(detector_);
  });
  say_(!refusal.empty(), refusal.empty() ? "the thresholds have changed" : refusal);
  config = configFrom(detector_);
  config.refusal = refusal;
}

}  // namespace bearing_calibration_ros
