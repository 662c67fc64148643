#include "bearing_calibration/vision/colour_identifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>
#include <vector>

#include "bearing_calibration/vision/light_detector.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

const Eigen::Vector3d kAmber(0.9, 0.5, 0.1);  // red, green, blue
const Eigen::Vector3d kBlue(0.1, 0.4, 1.0);

ColourConfig amberAndBlue() {
  ColourConfig config;
  config.use = true;
  config.lights = {{3, kAmber}, {5, kBlue}};
  config.tolerance = 0.1;
  return config;
}

/// Two lights of `peak` levels in their brightest channel, on a grey background, blue first.
cv::Mat imageOfTwo(const DetectorConfig& config, double peak) {
  std::vector<cv::Mat> channels;
  std::mt19937 random(3);
  for (int channel : {2, 1, 0}) {
    cv::Mat expected = test::flatImage(config.sensor.width_px, config.sensor.height_px, 20.0);
    const auto add = [&](double azimuth_rad, const Eigen::Vector3d& colour) {
      addSpot(&expected, test::spotOfLight(config, {1.0, -0.03}, azimuth_rad,
                                           peak * colour[channel] / colour.maxCoeff()));
    };
    add(0.7, kAmber);
    add(-2.0, kBlue);
    channels.push_back(test::expose(expected, config.sensor, &random));
  }
  cv::Mat bgr;
  cv::merge(channels, bgr);
  return bgr;
}

cv::Mat greyOf(const cv::Mat& bgr) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

std::vector<Detection> lightsIn(const DetectorConfig& config, const cv::Mat& grey) {
  return LightDetector(config).detect(grey).lights;
}

const Eigen::Vector3d& colourAt(double azimuth_rad) { return azimuth_rad > 0.0 ? kAmber : kBlue; }

TEST(ColourIdentifier, MeasuresTheRatiosOfTheLightOverItsBackground) {
  const DetectorConfig config = test::defaultDetector();
  const cv::Mat bgr = imageOfTwo(config, 200.0);
  const std::vector<Detection> lights = lightsIn(config, greyOf(bgr));
  ASSERT_EQ(lights.size(), 2u);
  const auto colours = coloursOf(bgr, lights, config);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Eigen::Vector3d& colour = colourAt(lights[i].bearing.azimuth_rad);
    ASSERT_TRUE(colours[i]);
    // Some 180 pixels of 2 levels' noise on 200: a part is known to 0.001, the background's median
    // to 0.2 levels.
    EXPECT_LT((*colours[i] - colour / colour.sum()).norm(), 0.005);
  }
}

// What is left and right of a light counts alike.
TEST(ColourIdentifier, AMirroredImageHasTheSameColours) {
  const DetectorConfig config = test::defaultDetector();
  constexpr int kU_px = 200;
  constexpr int kV_px = 150;
  Detection light;
  light.ellipse.centre_px = {kU_px, kV_px};
  light.ellipse.moments_px2 = 16.0 * Eigen::Matrix2d::Identity();
  Detection mirrored = light;
  mirrored.ellipse.centre_px.x() = config.sensor.width_px - 1 - kU_px;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    cv::Mat bgr(config.sensor.height_px, config.sensor.width_px, CV_8UC3);
    cv::RNG(seed).fill(bgr, cv::RNG::UNIFORM, 0, 100);
    cv::circle(bgr, {kU_px, kV_px}, 8, {50.0, 150.0, 240.0}, cv::FILLED);
    cv::Mat flipped;
    cv::flip(bgr, flipped, 1);
    const auto colour = coloursOf(bgr, {light}, config).front();
    const auto flipped_colour = coloursOf(flipped, {mirrored}, config).front();
    ASSERT_TRUE(colour && flipped_colour);
    EXPECT_LT((*colour - *flipped_colour).norm(), 1e-12) << seed;
  }
}

// More than there was may have been taken for its background: it has a pixel's size all the same.
TEST(ColourIdentifier, ASpotOfWhichNothingIsLeftHasNoColour) {
  const DetectorConfig config = test::defaultDetector();
  const cv::Mat bgr(config.sensor.height_px, config.sensor.width_px, CV_8UC3, {50.0, 150.0, 240.0});
  Detection light;
  light.ellipse.centre_px = {200.0, 150.0};
  light.ellipse.moments_px2 = -1.0 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(light.ellipse.variances_px2(), Eigen::Vector2d::Constant(kPixelVariance));
  EXPECT_FALSE(coloursOf(bgr, {light}, config).front());
}

/// Of lights whose middles are clipped: by the rim, whose pixels are lit in part.
void expectColoursWithoutFullPixels(const cv::Mat& bgr, const DetectorConfig& config) {
  const std::vector<Detection> lights = lightsIn(test::defaultDetector(), greyOf(bgr));
  ASSERT_EQ(lights.size(), 2u);
  const auto colours = coloursOf(bgr, lights, config);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    ASSERT_TRUE(colours[i]);
    const Eigen::Vector3d& colour = colourAt(lights[i].bearing.azimuth_rad);
    EXPECT_LT((*colours[i] - colour / colour.sum()).norm(), 0.02);
  }
}

TEST(ColourIdentifier, FullPixelsAreLeftOut) {
  expectColoursWithoutFullPixels(imageOfTwo(test::defaultDetector(), 300.0),
                                 test::defaultDetector());
}

// A sensor that clips early, and one of more bits than a picture in colours has.
TEST(ColourIdentifier, FullIsWhatTheSensorOrThePictureCannotExceed) {
  DetectorConfig config = test::defaultDetector();
  config.sensor.saturation_level = 180.0;
  expectColoursWithoutFullPixels(cv::min(imageOfTwo(test::defaultDetector(), 212.0), 180.0),
                                 config);
  config.sensor.saturation_level = 4000.0;
  expectColoursWithoutFullPixels(imageOfTwo(test::defaultDetector(), 300.0), config);
}

TEST(ColourIdentifier, NamesTheLightsByTheirColours) {
  const DetectorConfig config = test::defaultDetector();
  const cv::Mat bgr = imageOfTwo(config, 200.0);
  const std::vector<Detection> lights = lightsIn(config, greyOf(bgr));
  BearingSet set;
  for (const Detection& light : lights) set.candidates.push_back(light.bearing);
  identifyByColour(amberAndBlue(), coloursOf(bgr, lights, config), &set);
  ASSERT_EQ(set.candidates.size(), 2u);
  for (const Bearing& candidate : set.candidates) {
    EXPECT_EQ(candidate.light_id, candidate.azimuth_rad > 0.0 ? 3 : 5);
    EXPECT_GT(candidate.probability, 0.5);
  }
}

TEST(ColourIdentifier, WhatHasAnotherColourOrNoneIsNotTheLight) {
  BearingSet set;
  set.candidates.resize(3);
  for (Bearing& candidate : set.candidates) candidate.track_probability = 0.9;
  const ColourParts grey(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0);
  const ColourParts amber = kAmber / kAmber.sum();
  const ColourParts nearly_amber = amber + ColourParts(0.06, -0.06, 0.0);
  identifyByColour(amberAndBlue(), {grey, std::nullopt, nearly_amber}, &set);
  EXPECT_EQ(set.candidates[0].light_id, kUnknownLight);
  EXPECT_EQ(set.candidates[0].probability, 0.0);
  EXPECT_EQ(set.candidates[0].overallProbability(), 0.0);
  EXPECT_EQ(set.candidates[1].light_id, kUnknownLight);
  EXPECT_EQ(set.candidates[1].probability, 0.0);
  EXPECT_EQ(set.candidates[2].light_id, 3);
  EXPECT_EQ(set.candidates[2].probability, 1.0);
  EXPECT_EQ(set.candidates[2].overallProbability(), 0.9);
  EXPECT_THROW(identifyByColour(amberAndBlue(), {}, &set), std::invalid_argument);
}

TEST(ColourIdentifier, ADarkOrAFullSpotHasNoColour) {
  const DetectorConfig config = test::defaultDetector();
  Detection spot;
  spot.ellipse.centre_px = {450.0, 240.0};
  spot.ellipse.moments_px2 << 8.0, 0.0, 0.0, 25.0;
  for (int level : {20, 255}) {
    const cv::Mat flat(480, 640, CV_8UC3, cv::Scalar::all(level));
    EXPECT_FALSE(coloursOf(flat, {spot}, config).at(0)) << level;
  }
}

// Only its ends are not full, and lie farther from its middle than it is wide.
TEST(ColourIdentifier, TheEndsOfALongSpotTellItsColour) {
  Detection spot;
  spot.ellipse.centre_px = {450.0, 240.0};
  spot.ellipse.moments_px2 << 4.0, 0.0, 0.0, 64.0;
  const cv::Scalar background = cv::Scalar::all(20.0);
  cv::Mat bgr(480, 640, CV_8UC3, background);
  const auto fill = [&bgr](int half_length_px, const cv::Scalar& level) {
    constexpr int kHalfWidth_px = 4;
    bgr(cv::Rect(450 - half_length_px, 240 - kHalfWidth_px, 2 * half_length_px + 1,
                 2 * kHalfWidth_px + 1)) = level;
  };
  fill(17, background + 200.0 * cv::Scalar(kAmber[2], kAmber[1], kAmber[0]));
  fill(9, cv::Scalar::all(255.0));
  const auto colour = coloursOf(bgr, {spot}, test::defaultDetector()).at(0);
  ASSERT_TRUE(colour);
  EXPECT_LT((*colour - kAmber / kAmber.sum()).norm(), 1e-12);
}

TEST(ColourIdentifier, ValidateNamesEveryWrongValue) {
  EXPECT_TRUE(errorsOf(amberAndBlue()).empty());
  ColourConfig config;
  config.use = true;
  EXPECT_EQ(errorsOf(config).size(), 1u);
  config.lights = {
      {-1, kAmber}, {1, Eigen::Vector3d::Zero()}, {2, {1.0, -0.1, 0.0}}, {3, {1e7, 1.0, 1.0}}};
  config.tolerance = 2.0;
  EXPECT_EQ(errorsOf(config).size(), 5u);
}

}  // namespace
}  // namespace bearing_calibration::core
