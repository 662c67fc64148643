// Two lights of different colours, rendered on a mosaic, from the image message to light_id.

#include <gtest/gtest.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration_ros/image_bearings.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;
namespace encodings = sensor_msgs::image_encodings;

struct Lamp {
  std::int32_t light_id;
  double azimuth_rad;
  double red;  ///< against green
  double blue;
};
constexpr Lamp kAmber{3, 0.7, 1.6, 0.2};
constexpr Lamp kBlue{5, -2.0, 0.3, 1.8};

/// The photo-electrons of one lamp alone on an rggb mosaic.
std::vector<float> exposureOf(const Lamp& lamp) {
  core::RendererConfig config;
  config.reference_value = 110.0;  // of the green pixels
  config.reference_distance_m = 1.0;
  config.outside_mirror = 0.0;
  config.centre_brightness = 0.0;
  config.encoding.layout = core::ImageEncoding::Layout::kBayerRggb8;
  config.encoding.red_response = lamp.red;
  config.encoding.blue_response = lamp.blue;
  core::ImageRenderer renderer(config, [](double, double) { return 0.02; });
  core::Light light;
  light.height_m = config.reference_height_m;
  const core::Pose2 seeing_it{{-1.0, 0.0}, -lamp.azimuth_rad};
  return renderer.expose({light}, {seeing_it});
}

sensor_msgs::ImagePtr mosaicOf(const Lamp& first, const Lamp& second) {
  const core::RendererConfig config;
  const std::vector<float> one = exposureOf(first);
  const std::vector<float> other = exposureOf(second);
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = ros::Time(10.0);
  image->width = static_cast<std::uint32_t>(config.rig.width_px);
  image->height = static_cast<std::uint32_t>(config.rig.height_px);
  image->step = image->width;
  image->encoding = encodings::BAYER_RGGB8;
  const double levels_per_electron = 255.0 / config.pixels.full_well_electrons;
  for (std::size_t i = 0; i < one.size(); ++i) {
    const double level = levels_per_electron * static_cast<double>(one[i] + other[i]);
    image->data.push_back(static_cast<std::uint8_t>(std::lround(std::min(255.0, level))));
  }
  return image;
}

sensor_msgs::ImagePtr interpolated(const sensor_msgs::Image& mosaic) {
  auto image = boost::make_shared<sensor_msgs::Image>(mosaic);
  const cv::Mat raw(static_cast<int>(mosaic.height), static_cast<int>(mosaic.width), CV_8UC1,
                    const_cast<std::uint8_t*>(mosaic.data.data()));
  cv::Mat bgr;
  cv::cvtColor(raw, bgr, cv::COLOR_BayerBG2BGR);  // OpenCV's name of rggb
  image->encoding = encodings::BGR8;
  image->step = 3 * mosaic.width;
  image->data.assign(bgr.datastart, bgr.dataend);
  return image;
}

DetectionNodeConfig nodeConfig() {
  DetectionNodeConfig config;
  const core::CameraRig rig;
  config.detector = core::test::defaultDetector();
  config.detector.view = {rig.centre_px.x(), rig.centre_px.y(), rig.handedness};
  config.full_scan_every = 1;
  config.colour.use = true;
  config.colour.lights = {{kAmber.light_id, {kAmber.red, 1.0, kAmber.blue}},
                          {kBlue.light_id, {kBlue.red, 1.0, kBlue.blue}}};
  config.colour.tolerance = 0.1;
  return config;
}

TEST(ColouredLights, AreNamedInAMosaicAndInAColourImage) {
  const sensor_msgs::ImagePtr mosaic = mosaicOf(kAmber, kBlue);
  for (const sensor_msgs::ImagePtr& image : {mosaic, interpolated(*mosaic)}) {
    ImageBearings bearings(nodeConfig());
    const core::BearingSet set = bearings.detect(image, std::nullopt);
    ASSERT_EQ(set.candidates.size(), 2u) << image->encoding;
    for (const core::Bearing& candidate : set.candidates) {
      const Lamp& lamp = candidate.azimuth_rad > 0.0 ? kAmber : kBlue;
      EXPECT_NEAR(candidate.azimuth_rad, lamp.azimuth_rad, 0.001) << image->encoding;
      EXPECT_EQ(candidate.light_id, lamp.light_id) << image->encoding;
      EXPECT_GT(candidate.probability, 0.5) << image->encoding;
    }
  }
}

TEST(ColouredLights, OneOfAnotherColourIsNotTheLight) {
  DetectionNodeConfig config = nodeConfig();
  config.colour.lights.pop_back();
  ImageBearings bearings(config);
  const core::BearingSet set = bearings.detect(mosaicOf(kAmber, kBlue), std::nullopt);
  ASSERT_EQ(set.candidates.size(), 2u);
  for (const core::Bearing& candidate : set.candidates) {
    const bool is_amber = candidate.azimuth_rad > 0.0;
    EXPECT_EQ(candidate.light_id, is_amber ? kAmber.light_id : core::kUnknownLight);
    EXPECT_EQ(candidate.probability > 0.0, is_amber);
  }
}

TEST(ColouredLights, AGreyImageHasNone) {
  const sensor_msgs::ImagePtr image = mosaicOf(kAmber, kBlue);
  image->encoding = encodings::MONO8;
  ImageBearings bearings(nodeConfig());
  EXPECT_THROW(bearings.detect(image, std::nullopt), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration_ros
