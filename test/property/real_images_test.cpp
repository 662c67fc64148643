// Photographs that others took: what is no light must not be taken for one, and single pixels that
// are lights must be found. The pictures are found through BEARING_CALIBRATION_DATA.

#include <gtest/gtest.h>

#include <algorithm>

#include "bearing_calibration/vision/light_detector.h"
#include "support/photographs.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

/// The default rig in the middle of a picture of any size.
DetectorConfig detectorFor(const cv::Mat& image) {
  DetectorConfig config = test::defaultDetector();
  const double shorter_px = std::min(image.cols, image.rows);
  const double scale = shorter_px / config.sensor.height_px;
  config.mirror.pixel_pitch_m /= scale;
  config.sensor.width_px = image.cols;
  config.sensor.height_px = image.rows;
  config.view.centre_u_px = 0.5 * (image.cols - 1);
  config.view.centre_v_px = 0.5 * (image.rows - 1);
  config.mask.last_row = image.rows - 1;
  config.mask.outer_radius_px *= scale;
  config.mask.inner_radius_px *= scale;
  config.gates.max_pixels = static_cast<int>(config.gates.max_pixels * scale * scale);
  config.threshold.min_contrast_levels = 12.0;
  return config;
}

class MirrorScene : public testing::TestWithParam<const char*> {};

TEST_P(MirrorScene, HasNoConfidentLight) {
  const cv::Mat image = test::photograph(GetParam());
  if (image.empty()) GTEST_SKIP() << "BEARING_CALIBRATION_DATA is not set";
  LightDetector detector(detectorFor(image));
  const DetectionResult& result = detector.detect(image);
  EXPECT_FALSE(result.too_cluttered);
  EXPECT_FALSE(result.rejected.empty()) << "nothing bright was looked at";
  RecordProperty("rejected", static_cast<int>(result.rejected.size()));
  for (const Detection& light : result.lights) {
    EXPECT_LE(light.bearing.probability, 0.5) << "at " << light.ellipse.centre_px.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Pictures, MirrorScene,
                         testing::Values("hyperbolic_mirror_road.jpg", "parabolic_mirror_01.png",
                                         "parabolic_mirror_04.png"));

class LedGrid : public testing::TestWithParam<const char*> {};

TEST_P(LedGrid, ShowsItsManyLights) {
  const cv::Mat image = test::photograph(GetParam());
  if (image.empty()) GTEST_SKIP() << "BEARING_CALIBRATION_DATA is not set";
  DetectorConfig config = detectorFor(image);
  config.mirror_kind = MirrorKind::kOther;
  config.gates.min_pixels = 1;
  config.mask.inner_radius_px = 0.0;
  config.mask.outer_radius_px = image.cols + image.rows;  // all of the picture
  LightDetector detector(config);
  EXPECT_GE(detector.detect(image).lights.size(), 40u);
  EXPECT_LE(detector.detect(image).lights.size(), 60u) << "45 to 48 are there";
  RecordProperty("lights", static_cast<int>(detector.detect(image).lights.size()));
}

INSTANTIATE_TEST_SUITE_P(Pictures, LedGrid,
                         testing::Values("led_grid_fisheye_01.jpg", "led_grid_fisheye_02.jpg",
                                         "led_grid_fisheye_03.jpg", "led_grid_fisheye_04.jpg"));

}  // namespace
}  // namespace bearing_calibration::core
