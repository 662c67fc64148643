#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "bearing_calibration/vision/bright_spots.h"

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

TEST(Background, MeasuresMedianAndSpreadOfNoise) {
  const double rounded = std::sqrt(kStddev * kStddev + 1.0 / 12.0);
  // Of the 1935 samples' quantiles: sqrt(p (1 - p) / n) over the density, at three sigma.
  constexpr double kMedianError = 3.0 * 1.25 * kStddev / 44.0;
  constexpr double kSpreadError = 3.0 * 1.6 * kStddev / 44.0;
  for (int type : {CV_8UC1, CV_16UC1}) {
    const BackgroundLevel level = backgroundOf(noise(type), wholeRows(), 255.0);
    EXPECT_NEAR(level.median, kMean, kMedianError);
    EXPECT_NEAR(level.spread, rounded, kSpreadError);
  }
}

TEST(Background, ALampDoesNotWidenTheSpread) {
  cv::Mat image = noise(CV_8UC1);
  image.colRange(0, 80).setTo(255);  // a fifth: the median is the 62.5 % quantile of the rest
  const BackgroundLevel level = backgroundOf(image, wholeRows(), 255.0);
  EXPECT_NEAR(level.median, kMean + 0.32 * kStddev, 0.4);
  EXPECT_LT(level.spread, 1.5 * kStddev);
}

TEST(Background, NoPixelIsNoLevel) {
  EXPECT_EQ(backgroundOf(noise(CV_8UC1), {}, 255.0).median, 0.0);
}

TEST(Thresholds, RisesToWhatIsFullAndEndsBelowTheFirst) {
  ThresholdConfig config;
  config.spreads = 6.0;
  config.min_contrast_levels = 5.0;
  ImageSensor sensor;
  sensor.saturation_level = 250.0;
  const Thresholds rising = thresholdsOver({40.0, 3.0}, config, sensor);
  EXPECT_EQ(rising[0], 58);
  const std::size_t last = rising.size() - 1;
  for (std::size_t step = 1; step < last; ++step) EXPECT_GT(rising[step], rising[step - 1]);
  EXPECT_EQ(rising[last - 1], 249);
  EXPECT_EQ(rising[last], 49);
  EXPECT_EQ(thresholdsOver({2.0, 0.1}, config, sensor)[0], 7);
  for (int white : thresholdsOver({252.0, 1.0}, config, sensor)) EXPECT_EQ(white, 249);
}

}  // namespace
}  // namespace bearing_calibration::core
