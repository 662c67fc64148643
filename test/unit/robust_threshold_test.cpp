#include "bearing_calibration/vision/robust_threshold.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace bearing_calibration::core {
namespace {

constexpr double kMean = 40.0;
constexpr double kStddev = 3.0;

cv::Mat noise(int type) {
  cv::Mat image(300, 400, type);
  cv::RNG random(1);
  random.fill(image, cv::RNG::NORMAL, kMean, kStddev);
  return image;
}

std::vector<PixelStrip> wholeRows() {
  std::vector<PixelStrip> strips;
  for (int v = 0; v < 300; ++v) strips.push_back({v, 0, 400});
  return strips;
}

TEST(BackgroundSampler, MeasuresMedianAndSpreadOfNoise) {
  const double rounded = std::sqrt(kStddev * kStddev + 1.0 / 12.0);
  // Of the 1935 samples' quantiles: sqrt(p (1 - p) / n) over the density, at three sigma.
  constexpr double kMedianError = 3.0 * 1.25 * kStddev / 44.0;
  constexpr double kSpreadError = 3.0 * 1.6 * kStddev / 44.0;
  for (int type : {CV_8UC1, CV_16UC1}) {
    BackgroundSampler sampler(255.0);
    const BackgroundLevel level = sampler.measure(noise(type), wholeRows());
    EXPECT_NEAR(level.median, kMean, kMedianError);
    EXPECT_NEAR(level.spread, rounded, kSpreadError);
  }
}

TEST(BackgroundSampler, ALampDoesNotWidenTheSpread) {
  cv::Mat image = noise(CV_8UC1);
  image.colRange(0, 80).setTo(255);  // a fifth: the median is the 62.5 % quantile of the rest
  const BackgroundLevel level = BackgroundSampler(255.0).measure(image, wholeRows());
  EXPECT_NEAR(level.median, kMean + 0.32 * kStddev, 0.4);
  EXPECT_LT(level.spread, 1.5 * kStddev);
}

TEST(BackgroundSampler, NoPixelIsNoLevel) {
  BackgroundSampler sampler(255.0);
  EXPECT_EQ(sampler.measure(noise(CV_8UC1), {}).median, 0.0);
}

TEST(ThresholdLadder, RisesToWhatIsFullAndEndsBelowTheFirst) {
  ThresholdConfig config;
  config.spreads = 6.0;
  config.min_contrast_levels = 5.0;
  ImageSensor sensor;
  sensor.saturation_level = 250.0;
  const ThresholdLadder ladder({40.0, 3.0}, config, sensor);
  EXPECT_EQ(ladder.at(0), 58);
  for (int step = 1; step < ThresholdLadder::kSteps - 1; ++step) {
    EXPECT_GT(ladder.at(step), ladder.at(step - 1));
  }
  EXPECT_EQ(ladder.at(ThresholdLadder::kSteps - 2), 249);
  EXPECT_EQ(ladder.at(ThresholdLadder::kSteps - 1), 49);
  const ThresholdLadder dark({2.0, 0.1}, config, sensor);
  EXPECT_EQ(dark.at(0), 7);
  const ThresholdLadder white({252.0, 1.0}, config, sensor);
  for (int step = 0; step < ThresholdLadder::kSteps; ++step) EXPECT_EQ(white.at(step), 249);
}

}  // namespace
}  // namespace bearing_calibration::core
