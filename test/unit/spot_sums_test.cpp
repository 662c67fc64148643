#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "bearing_calibration/vision/spot_meter.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

constexpr int kRows = 23;
constexpr int kColumns = 37;  // no multiple of what a loop takes at once
const Eigen::Vector2d kCentre_px(30.3, 18.2);
const Eigen::Matrix2d kCovariance_px2 = (Eigen::Matrix2d() << 9.0, 2.0, 2.0, 6.0).finished();

/// Squared Mahalanobis distance from the centre.
double metricAt(int u, int v) {
  const double du = u - kCentre_px.x();
  const double dv = v - kCentre_px.y();
  return 0.12 * du * du - 0.08 * du * dv + 0.18 * dv * dv;
}

/// Noise about a light, in an image that cuts its ellipse on the right and below.
template <typename Level>
cv::Mat noisyLight() {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 2.0);
  cv::Mat image(kRows, kColumns, cv::DataType<Level>::type);
  for (int v = 0; v < kRows; ++v) {
    for (int u = 0; u < kColumns; ++u) {
      const double light = metricAt(u, v) < 4.0 ? 150.0 : 0.0;
      image.at<Level>(v, u) = static_cast<Level>(20.5 + 0.1 * u - 0.2 * v + light + noise(random));
    }
  }
  return image;
}

const PixelEllipse kWindow{kCentre_px, kCovariance_px2, 2.5};
constexpr double kReach2 = 6.25;
const LevelPlane kPlane{19.6, {0.1, -0.2}};
constexpr WeightPolynomial kWeight{0.0F, 1.0F, -1.0F / 39.0625F};

/// Of noise 0.1 (I - 4) + 1e-4 (I - b)^2, full at 170.
ImageSensor sensor() {
  ImageSensor sensor;
  sensor.black_level = 4.0;
  sensor.saturation_level = 170.0;
  sensor.electrons_per_level = 10.0;
  sensor.response_spread = 0.01;
  return sensor;
}

/// Equal to what a sum of so many floats keeps.
void expectNear(double sum, double expected, double scale) {
  EXPECT_NEAR(sum, expected, 1e-5 * scale);
}

/// Calls visit(u, v, m2, level) for one pixel after the other of every row_step-th row.
template <typename Level, typename Visit>
void forEachPixel(const cv::Mat& image, int first_row, int row_step, Visit visit) {
  for (int v = first_row; v < kRows; v += row_step) {
    for (int u = 0; u < kColumns; ++u) visit(u, v, metricAt(u, v), image.at<Level>(v, u));
  }
}

/// The first row of an ellipse with these deviations.
int firstRowOf(double size) {
  return static_cast<int>(kCentre_px.y() - size * std::sqrt(kCovariance_px2(1, 1)) + 1.0);
}

template <typename Level>
void expectSumsOfAPlainLoop(int row_step) {
  const cv::Mat image = noisyLight<Level>();
  double light = 0.0;
  double weighted = 0.0;
  double moment_u = 0.0;
  double sloped_uv = 0.0;
  double light_uu = 0.0;
  double light_vv = 0.0;
  double noise_uu = 0.0;
  double fourth_powers = 0.0;
  double peak = 0.0;
  int full = 0;
  forEachPixel<Level>(image, firstRowOf(kWindow.size), row_step,
                      [&](int u, int v, double m2, double level) {
                        if (m2 > kReach2) return;
                        const double du = u - kCentre_px.x();
                        const double dv = v - kCentre_px.y();
                        const double over = level - 19.6 - 0.1 * du + 0.2 * dv;
                        const double weight = m2 * (1.0 - m2 * m2 / 39.0625);
                        const bool is_full = level >= 170.0;
                        const double variance =
                            (is_full ? 0.0 : 0.1 * std::max(0.0, level - 4.0)) + 1e-4 * over * over;
                        light += over;
                        weighted += over * weight;
                        moment_u += over * weight * du;
                        sloped_uv += over * (1.0 - 3.0 * m2 * m2 / 39.0625) * du * dv;
                        light_uu += over * du * du;
                        light_vv += over * dv * dv;
                        noise_uu += variance * weight * weight * du * du;
                        fourth_powers += over * m2 * m2;
                        peak = std::max(peak, level);
                        full += is_full ? 1 : 0;
                      });
  ASSERT_GT(full, 3);
  const CentreMoments centre = sumCentre(image, kWindow, row_step, kWeight, kPlane);
  expectNear(centre.light, light, light);
  expectNear(centre.weighted, weighted, weighted);
  expectNear(centre.moment.x(), moment_u, 10.0 * weighted);
  expectNear(centre.sloped_squares(0, 1), sloped_uv, 10.0 * weighted);
  const SpreadMoments spread =
      sumSpread(image, image, kWindow, row_step, kWeight, kPlane, sensor());
  expectNear(spread.light, light, light);
  expectNear(spread.light_squares(0, 0), light_uu, light_uu);
  expectNear(spread.light_squares(1, 1), light_vv, light_vv);
  expectNear(spread.noise_squares(0, 0), noise_uu, noise_uu);
  expectNear(spread.fourth_powers, fourth_powers, fourth_powers);
  EXPECT_EQ(spread.peak, peak);
  EXPECT_EQ(spread.full_pixels, full);
}

TEST(SpotSums, SumAnEllipseAsAPlainLoopDoes) {
  for (int row_step : {1, 2}) {
    expectSumsOfAPlainLoop<std::uint8_t>(row_step);
    expectSumsOfAPlainLoop<std::uint16_t>(row_step);
  }
}

TEST(SpotSums, CountFullPixelsInTheImageThatTheSensorTook) {
  const cv::Mat image = noisyLight<std::uint8_t>();
  const cv::Mat full(image.size(), image.type(), cv::Scalar(200));
  const SpreadMoments spread =
      sumSpread(image, full, {kCentre_px, kCovariance_px2, 1.0}, 1, kWeight, kPlane, sensor());
  int pixels = 0;
  forEachPixel<std::uint8_t>(image, 0, 1,
                             [&](int, int, double m2, double) { pixels += m2 <= 1.0 ? 1 : 0; });
  EXPECT_EQ(spread.full_pixels, pixels);
}

TEST(SpotSums, SumTheDarkPixelsOfARing) {
  const cv::Mat image = noisyLight<std::uint8_t>();
  double n = 0.0;
  double n_u = 0.0;
  double n_uv = 0.0;
  double level_v = 0.0;
  double level2 = 0.0;
  forEachPixel<std::uint8_t>(image, 0, 1, [&](int u, int v, double m2, double level) {
    if (m2 <= 4.0 || m2 > 9.0 || level > 21.0) return;
    const double du = u - kCentre_px.x();
    const double dv = v - kCentre_px.y();
    n += 1.0;
    n_u += du;
    n_uv += du * dv;
    level_v += (level - 20.0) * dv;
    level2 += (level - 20.0) * (level - 20.0);
  });
  ASSERT_GT(n, 30.0);
  const PlaneSums sums = sumPlane(image, {kCentre_px, kCovariance_px2, 2.0}, 3.0, 1, 21.0, 20.0);
  EXPECT_EQ(sums.normal(0, 0), n);
  expectNear(sums.normal(0, 1), n_u, 10.0 * n);
  expectNear(sums.normal(1, 2), n_uv, 50.0 * n);
  expectNear(sums.right(2), level_v, 10.0 * n);
  expectNear(sums.squares, level2, level2);
}

TEST(SpotSums, AnEllipseWiderThanTheImageIsCutAtItsSides) {
  const cv::Mat image(9, 11, CV_8UC1, cv::Scalar(50));
  const PixelEllipse wide{{5.0, 4.0}, 1e4 * Eigen::Matrix2d::Identity(), 2.0};
  EXPECT_EQ(sumCentre(image, wide, 1, {1.0F, 0.0F, 0.0F}, {}).light, 50.0 * 9 * 11);
}

// By two fifths of the light's radius, as where a half of it is over the threshold: the second step
// begins where the first has ended.
TEST(MeasureSpot, FindsTheCentreFromPixelsWhoseMiddleIsOff) {
  const DetectorConfig config = test::defaultDetector();
  const test::SpotDrawing spot =
      test::spotOfLight(config, {0.5, test::kDefaultLightHeight_m}, 0.3, 150.0);
  cv::Mat expected = test::flatImage(config.sensor.width_px, config.sensor.height_px, 20.0);
  addSpot(&expected, spot);
  cv::Mat levels;
  expected.convertTo(levels, CV_8U);
  LightEllipse thresholded;
  thresholded.moments_px2 = std::pow(spot.major_diameter_px / 4.0, 2) * Eigen::Matrix2d::Identity();
  Search search;
  search.background_levels = 20.0;
  search.threshold_levels = 40.0;
  for (const double off_px : {-4.0, 0.0, 4.0}) {
    thresholded.centre_px = spot.centre_px + Eigen::Vector2d(off_px, 0.0);
    const SpotWindow window = windowFor(thresholded, nullptr, config);
    const auto light = measureSpot({levels, levels}, thresholded, window, search, config);
    ASSERT_TRUE(light.has_value());
    EXPECT_LT((light->centre_px - spot.centre_px).norm(), 0.02) << off_px;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
