#include "fuzz/detection_fuzzer.h"

#include <boost/make_shared.hpp>

#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "fuzz/bearing_check.h"
#include "fuzz/harness.h"
#include "fuzz/image_input.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;
using bearing_calibration::fuzz::require;

/// The default rig behind a sensor of the image's size, which must be able to be one.
core::DetectorConfig configFor(const sensor_msgs::Image& image) {
  core::DetectorConfig config = core::test::defaultDetector();
  config.sensor.width_px = static_cast<int>(image.width);
  config.sensor.height_px = static_cast<int>(image.height);
  config.view.centre_u_px = 0.5 * (config.sensor.width_px - 1.0);
  config.view.centre_v_px = 0.5 * (config.sensor.height_px - 1.0);
  config.mask.last_row = config.sensor.height_px - 1;
  config.threshold.min_contrast_levels = 1.0;  // more to look at
  return config;
}

void requireMeaning(const core::DetectionResult& result) {
  for (const core::Detection& light : result.lights) {
    bearing_calibration::fuzz::requireBearing(light.bearing);
  }
}

}  // namespace

core::LightDetector& DetectionFuzzer::detectorFor(const sensor_msgs::Image& image) {
  auto& detector = detectors_[{image.width, image.height}];
  if (!detector) detector = std::make_unique<core::LightDetector>(configFor(image));
  return *detector;
}

bool DetectionFuzzer::run(const sensor_msgs::Image& image) {
  core::ImageSensor sensor;
  sensor.width_px = static_cast<int>(image.width);  // of any size: the detector fits itself to it
  sensor.height_px = static_cast<int>(image.height);
  sensor.saturation_level = 255.0;
  if (const auto refusal = refusalOf(image, sensor)) {
    require(!refusal->kind.empty() && !refusal->text.empty(), "a refusal says nothing");
    return false;
  }
  core::LightDetector& detector = detectorFor(image);
  const cv::Mat& grey = converter_.convert(boost::make_shared<sensor_msgs::Image>(image));
  constexpr double kPredicted_rad = 1.0;
  constexpr double kHalfWidth_rad = 0.2;
  constexpr double kHalfHeight_px = 5.0;
  const core::MirrorPixel centre{0.3 * sensor.width_px, kPredicted_rad};
  const core::SearchRegion region{core::ExpectedPlace{centre, kHalfWidth_rad, kHalfHeight_px},
                                  {kPredicted_rad, kHalfWidth_rad}};
  requireMeaning(detector.detect(grey, region));
  const core::DetectionResult& result = detector.detect(grey);
  requireMeaning(result);
  core::ShutterConfig shutter;
  shutter.row_time_s = 1e-5;
  core::bearingsFromLights(result.lights, shutter, core::stampFromSeconds(1.0), grey.rows);
  core::annotate(grey, result, detector.config());
  return true;
}

}  // namespace bearing_calibration_ros

bool bearing_calibration::fuzz::run(const std::uint8_t* data, std::size_t size) {
  static bearing_calibration_ros::DetectionFuzzer fuzzer;
  ByteReader bytes(data, size);
  return fuzzer.run(bearing_calibration_ros::imageFrom(&bytes));
}
