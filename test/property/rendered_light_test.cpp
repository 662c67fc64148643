// The detector on ray-traced images: the renderer shares no optics with it. The figures asked for
// are the package's own aims (doc/detection.md).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/rendered_sights.h"

namespace bearing_calibration {
namespace {

using test::BearingErrors;
using test::imageOf;
using test::randomSights;
using test::Sight;

void report(const BearingErrors& errors) {
  testing::Test::RecordProperty("rmse_deg", std::to_string(errors.rmse_deg()));
  testing::Test::RecordProperty("bias_deg", std::to_string(errors.bias_deg()));
  testing::Test::RecordProperty("nees", std::to_string(errors.nees()));
}

class RenderedLight : public testing::Test {
 protected:
  RenderedLight()
      : renderer_(test::renderedRig(), test::plainWall),
        detector_(test::detectorOf(test::renderedRig())) {}

  /// Adds the only light of an image, when there is just one.
  void add(const cv::Mat& image, const Sight& sight, BearingErrors* errors) {
    const DetectionResult& result = detector_.detect(image);
    if (result.lights.size() == 1) {
      errors->add(result.lights.front().bearing, sight.azimuth_rad);
    }
  }

  BearingErrors errorsOf(const std::vector<Sight>& sights) {
    BearingErrors errors;
    for (std::size_t i = 0; i < sights.size(); ++i) {
      const Sight& sight = sights[i];
      add(imageOf(renderer_.render({sight.light()}, sight.worldFromSensor(), i)), sight, &errors);
    }
    report(errors);
    return errors;
  }

  ImageRenderer renderer_;
  LightDetector detector_;
};

TEST_F(RenderedLight, ACleanPointIsReadToAHundredthOfADegree) {
  const std::vector<Sight> sights = randomSights(200, 1.0, 31);
  const BearingErrors errors = errorsOf(sights);
  EXPECT_EQ(errors.found, 200);
  EXPECT_LT(errors.rmse_deg(), 0.01);
  EXPECT_LT(std::abs(errors.bias_deg()), 0.001);
  EXPECT_LT(errors.nees(), 1.3);
  EXPECT_GT(errors.nees(), 0.4);
  double bound = 0.0;
  constexpr int kBounds = 10;  // they are slow, and vary little
  for (int i = 0; i < kBounds; ++i) {
    bound +=
        azimuthBound(&renderer_, detector_.config().sensor, sights[static_cast<std::size_t>(i)]) /
        kBounds;
  }
  const double ratio = std::sqrt(errors.sum_square_rad2 / errors.found / bound);
  RecordProperty("rmse_over_bound", std::to_string(ratio));
  EXPECT_LT(ratio, 1.8);
  EXPECT_GT(ratio, 0.8) << "below the Cramer-Rao bound";
}

TEST_F(RenderedLight, ASaturatedPointIsReadToTwoHundredthsOfADegree) {
  constexpr double kFourTimesFull = 5.7;
  const BearingErrors errors = errorsOf(randomSights(100, kFourTimesFull, 32));
  EXPECT_EQ(errors.found, 100);
  EXPECT_LT(errors.rmse_deg(), 0.02);
  EXPECT_LT(errors.nees(), 1.3);
}

TEST_F(RenderedLight, JpegIsInTheVariance) {
  constexpr int kQuality = 90;
  const std::vector<Sight> sights = randomSights(100, 1.0, 35);
  BearingErrors errors;
  std::vector<std::uint8_t> file;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Sight& sight = sights[i];
    const cv::Mat image = imageOf(renderer_.render({sight.light()}, sight.worldFromSensor(), i));
    cv::imencode(".jpg", image, file, {cv::IMWRITE_JPEG_QUALITY, kQuality});
    add(cv::imdecode(file, cv::IMREAD_GRAYSCALE), sight, &errors);
  }
  report(errors);
  EXPECT_EQ(errors.found, 100);
  EXPECT_LT(errors.nees(), 1.3);
}

// 5 ms at 1 rad/s, the azimuth that counts being that of mid-exposure.
TEST_F(RenderedLight, MotionBlurDoesNotMoveTheBearing) {
  constexpr double kBlur_rad = 0.005;
  constexpr int kParts = 6;
  const std::vector<Sight> sights = randomSights(30, 1.0, 36);
  const PixelNoise noise(test::renderedRig().pixels, 37);
  BearingErrors errors;
  MonoImage image{640, 480, {}};
  for (std::size_t i = 0; i < sights.size(); ++i) {
    std::vector<float> mean(static_cast<std::size_t>(image.width_px * image.height_px), 0.0F);
    for (int part = 0; part < kParts; ++part) {
      Sight moved = sights[i];
      moved.azimuth_rad += kBlur_rad * ((part + 0.5) / kParts - 0.5);
      const auto& electrons = renderer_.expose({moved.light()}, moved.worldFromSensor());
      for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += electrons[k] / kParts;
    }
    noise.digitize(mean, i, &image.values);
    add(imageOf(image), sights[i], &errors);
  }
  report(errors);
  EXPECT_EQ(errors.found, 30);
  EXPECT_LT(std::abs(errors.bias_deg()), 0.001);
  EXPECT_LT(errors.nees(), 1.3);
}

/// LEDs around a holder of 20 mm radius, unequally bright: their centroid is not the holder's
/// centre.
class LedRing : public testing::TestWithParam<double> {
 protected:
  static constexpr double kRadius_m = 0.02;
  static constexpr int kLeds = 8;

  static std::vector<Light> ring(const Sight& sight, double spread, std::mt19937* random) {
    std::normal_distribution<double> normal;
    std::vector<Light> leds;
    for (int i = 0; i < kLeds; ++i) {
      const double angle = 2.0 * kPi * i / kLeds;
      Light led = sight.light();
      led.position_m = kRadius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      led.brightness *= std::max(0.0, 1.0 + spread * normal(*random)) / kLeds;
      leds.push_back(led);
    }
    return leds;
  }
};

TEST_P(LedRing, TheVarianceKnowsOfUnequalLeds) {
  RendererConfig rendered = test::renderedRig();
  rendered.rays_per_light = 1 << 13;  // for each LED
  ImageRenderer renderer(rendered, test::plainWall);
  DetectorConfig config = test::detectorOf(rendered);
  config.light.radius_m = kRadius_m;
  config.light.brightness_spread = GetParam();
  LightDetector detector(config);
  std::mt19937 random(33);
  BearingErrors errors;
  const std::vector<Sight> sights = randomSights(150, 1.0, 34);
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Sight& sight = sights[i];
    const cv::Mat image =
        imageOf(renderer.render(ring(sight, GetParam(), &random), sight.worldFromSensor(), i));
    const DetectionResult& result = detector.detect(image);
    if (result.lights.size() == 1) {
      errors.add(result.lights.front().bearing, sight.azimuth_rad);
    }
  }
  report(errors);
  EXPECT_GE(errors.found, 147);  // a near ring may look like no ellipse
  EXPECT_LT(errors.nees(), 1.3);
  EXPECT_GT(errors.nees(), 0.4);
}

INSTANTIATE_TEST_SUITE_P(BrightnessSpreads, LedRing, testing::Values(0.1, 0.3));

}  // namespace
}  // namespace bearing_calibration
