// Rendered images: exposure, noise and surroundings against what they are made of.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/simulation/image_renderer.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

/// A test at this level fails by chance in one of 1000 seeds; the seeds are fixed.
constexpr double kTail = 0.0005;

Light lightOf(const RendererConfig& config) {
  Light light;
  light.height_m = config.reference_height_m;
  return light;
}

/// The sensor's pose that sees the light at the origin at `azimuth_rad`, `distance_m` away.
Pose2 poseSeeing(double distance_m, double azimuth_rad) {
  return {{-distance_m, 0.0}, wrapAngle(-azimuth_rad)};
}

double darkness(double, double) { return 0.0; }

/// An image with nothing in it but the light.
RendererConfig darkConfig() {
  RendererConfig config;
  config.outside_mirror = 0.0;
  config.centre_brightness = 0.0;
  return config;
}

Vector2d pixelOf(const RendererConfig& config, std::size_t index) {
  const auto width = static_cast<std::size_t>(config.rig.width_px);
  return {static_cast<double>(index % width), static_cast<double>(index / width)};
}

double azimuthOfPixel(const CameraRig& rig, const Vector2d& pixel) {
  return rig.handedness *
         std::atan2(-(pixel.y() - rig.centre_px.y()), pixel.x() - rig.centre_px.x());
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Electrons inside the central half of the spot of a light at the reference distance.
std::vector<double> plateauOf(const RendererConfig& config, ImageRenderer* renderer) {
  const Pose2 pose = poseSeeing(config.reference_distance_m, 0.3);
  const auto& electrons = renderer->expose({lightOf(config)}, {pose});
  const SpotMoments spot =
      LightSpot(config.rig, config.rays_per_light).moments(inSensor(lightOf(config), pose));
  const Eigen::Matrix2d information = spot.covariance_px2.inverse();
  std::vector<double> plateau;
  for (std::size_t i = 0; i < electrons.size(); ++i) {
    const Vector2d offset = pixelOf(config, i) - spot.mean_px;
    // The ellipse's edge lies at a Mahalanobis distance of 2.
    if (offset.dot(information * offset) < 1.0) {
      plateau.push_back(static_cast<double>(electrons[i]));
    }
  }
  return plateau;
}

TEST(ImageRenderer, ReferenceLightReachesItsValue) {
  const RendererConfig config = darkConfig();
  ImageRenderer renderer(config, darkness);
  const std::vector<double> plateau = plateauOf(config, &renderer);
  const double expected = 180.0 / 255.0 * config.pixels.full_well_electrons;
  EXPECT_NEAR(mean(plateau) / expected, 1.0, 0.02);  // the beam's flux is not quite even
}

// Rays are so many that their grain is below the shot noise of a bright pixel.
TEST(ImageRenderer, GrainOfTheRaysIsBelowTheShotNoise) {
  const RendererConfig config = darkConfig();
  ImageRenderer renderer(config, darkness);
  const std::vector<double> plateau = plateauOf(config, &renderer);
  const double average = mean(plateau);
  double square = 0.0;
  for (double value : plateau) square += (value - average) * (value - average);
  const double grain = std::sqrt(square / static_cast<double>(plateau.size()));
  EXPECT_LT(grain, std::sqrt(average));
}

// Each ray's pixel-wide square widens the spot by 1/12 px^2, the pixels' own area by 1/12 again.
TEST(ImageRenderer, KeepsFluxCentroidAndSpreadOfTheSpot) {
  const RendererConfig config = darkConfig();
  ImageRenderer renderer(config, darkness);
  for (double azimuth : {-3.0, -1.2, 0.1, 0.8, 2.5}) {
    for (double distance_m : {0.7, 1.5, 4.0}) {
      const Pose2 pose = poseSeeing(distance_m, azimuth);
      const SpotMoments spot =
          LightSpot(config.rig, config.rays_per_light).moments(inSensor(lightOf(config), pose));
      const auto& electrons = renderer.expose({lightOf(config)}, {pose});
      double sum = 0.0;
      Vector2d first = Vector2d::Zero();
      Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
      for (std::size_t i = 0; i < electrons.size(); ++i) {
        const double value = static_cast<double>(electrons[i]);
        const Vector2d offset = pixelOf(config, i) - spot.mean_px;
        sum += value;
        first += value * offset;
        second += value * offset * offset.transpose();
      }
      const Vector2d shift = first / sum;
      EXPECT_LT(shift.norm(), 1e-4);  // px: bilinear shares keep the centroid, up to rounding
      const Eigen::Matrix2d widening = second / sum - spot.covariance_px2;
      EXPECT_NEAR(widening(0, 0), 1.0 / 6.0, 0.01);
      EXPECT_NEAR(widening(1, 1), 1.0 / 6.0, 0.01);
      EXPECT_NEAR(widening(0, 1), 0.0, 0.01);
      const double bias = azimuthOfPixel(config.rig, spot.mean_px + shift) - azimuth;
      EXPECT_NEAR(degreesFromRadians(wrapAngle(bias)), 0.0, 1e-3);
    }
  }
}

TEST(Digitize, IsShotAndReadNoiseInEightBits) {
  constexpr std::size_t kPixels = 100000;
  const PixelConfig pixels;
  const double electrons_per_value = pixels.full_well_electrons / PixelConfig::kLargestValue;
  for (double level : {600.0, 3000.0, 9000.0}) {
    const std::vector<float> grey(kPixels, static_cast<float>(level));
    const std::vector<std::uint8_t> values = digitize(grey, pixels, 7, 3);
    double sum = 0.0;
    double square = 0.0;
    for (std::uint8_t value : values) {
      const double error = value * electrons_per_value - level;
      sum += error;
      square += error * error;
    }
    // Photons, amplifier, and rounding to whole values (uniform over one step).
    const double variance = level + pixels.read_noise_electrons * pixels.read_noise_electrons +
                            electrons_per_value * electrons_per_value / 12.0;
    EXPECT_GT(square / variance, chiSquareQuantile(kTail, kPixels)) << level;
    EXPECT_LT(square / variance, chiSquareQuantile(1.0 - kTail, kPixels)) << level;
    EXPECT_LT(sum * sum / (kPixels * variance), chiSquareQuantile(1.0 - 2.0 * kTail, 1.0));
  }
}

TEST(Digitize, IsFreshInEachImageAndTheSameForTheSameNumber) {
  constexpr std::size_t kPixels = 20000;
  const std::vector<float> grey(kPixels, 6000.0F);
  const std::vector<std::uint8_t> first = digitize(grey, {}, 7, 1);
  const std::vector<std::uint8_t> next = digitize(grey, {}, 7, 2);
  EXPECT_EQ(first, digitize(grey, {}, 7, 1));
  EXPECT_NE(first, digitize(grey, {}, 8, 1));
  // Correlations between images, and between neighbours, are within the chance of n pairs.
  const double average = 6000.0 * 255.0 / 12000.0;
  double between = 0.0;
  double beside = 0.0;
  double square = 0.0;
  for (std::size_t i = 1; i < kPixels; ++i) {
    between += (first[i] - average) * (next[i] - average);
    beside += (first[i] - average) * (first[i - 1] - average);
    square += (first[i] - average) * (first[i] - average);
  }
  const double bound = std::sqrt(chiSquareQuantile(1.0 - 2.0 * kTail, 1.0) / kPixels);
  EXPECT_LT(std::abs(between / square), bound);
  EXPECT_LT(std::abs(beside / square), bound);
}

TEST(Digitize, SaturatesAtTheFullWell) {
  std::vector<std::uint8_t> values = digitize(std::vector<float>(1000, 30000.0F), {}, 1, 1);
  EXPECT_EQ(*std::min_element(values.begin(), values.end()), 255);
  values = digitize(std::vector<float>(1000, 0.0F), {}, 1, 1);
  EXPECT_LE(*std::max_element(values.begin(), values.end()), 2);
}

// A function of the direction alone: a pixel of azimuth a sees the world's azimuth a + yaw.
TEST(ImageRenderer, SurroundingsTurnWithTheRobot) {
  RendererConfig config;
  config.rig.aperture_m = 1e-6;  // no defocus: the surroundings are as sharp as they are
  const auto radiance = [](double azimuth, double) { return 0.2 + 0.1 * std::sin(3.0 * azimuth); };
  ImageRenderer renderer(config, radiance);
  for (double yaw : {-2.0, 0.0, 1.3}) {
    const auto& electrons = renderer.expose({}, {{{5.0, 3.0}, yaw}});
    for (std::size_t i = 0; i < electrons.size(); i += 37) {
      const Vector2d pixel = pixelOf(config, i);
      const double radius = (pixel - config.rig.centre_px).norm();
      if (radius < config.centre_radius_px) {
        ASSERT_FLOAT_EQ(electrons[i], static_cast<float>(config.centre_brightness * 12000.0));
      } else if (!renderer.tracer().directionSeenBy(pixel)) {
        ASSERT_FLOAT_EQ(electrons[i], static_cast<float>(config.outside_mirror * 12000.0));
      } else {
        const double expected = 12000.0 * radiance(azimuthOfPixel(config.rig, pixel) + yaw, 0.0);
        // Straight lines between columns of 3.1 mrad: 0.1 * 9 * step^2 / 8 of a full well.
        ASSERT_NEAR(static_cast<double>(electrons[i]), expected, 0.05) << pixel.transpose();
      }
    }
  }
}

// A step of the surroundings' brightness becomes as soft as the lens is out of focus.
TEST(ImageRenderer, SurroundingsAreDefocusedLikeALight) {
  const RendererConfig config;
  const auto half_bright = [](double azimuth, double) {
    return wrapAngle(azimuth) > 0.0 ? 0.4 : 0.0;
  };
  ImageRenderer renderer(config, half_bright);
  const SpotMoments spot = LightSpot(config.rig, config.rays_per_light).moments({{100.0, 0.0}});
  const double radius_px = (spot.mean_px - config.rig.centre_px).norm();
  const double stddev_px = std::sqrt(spot.covariance_px2(1, 1));
  const auto& electrons = renderer.expose({}, {});
  // Down the column of a pixel that looks along the edge: the part of the step passed at one
  // standard deviation is that of a Gaussian.
  const int column = static_cast<int>(std::lround(config.rig.centre_px.x() + radius_px));
  double soft_pixels = 0.0;
  for (int row = 200; row < 280; ++row) {
    const double value =
        static_cast<double>(
            electrons[static_cast<std::size_t>(row * config.rig.width_px + column)]) /
        (0.4 * config.pixels.full_well_electrons);
    soft_pixels += value * (1.0 - value);
  }
  // The integral of Phi (1 - Phi) is the standard deviation over sqrt(pi).
  EXPECT_NEAR(soft_pixels, stddev_px / std::sqrt(kPi), 0.1);
}

TEST(ImageRenderer, SameNumberSameImage) {
  const RendererConfig config;
  ImageRenderer first(config, roomRadiance({}));
  ImageRenderer second(config, roomRadiance({}));
  const Pose2 pose = poseSeeing(1.2, 2.0);
  const cv::Mat image = first.render({lightOf(config)}, {pose}, 5);
  EXPECT_EQ(image.size(), cv::Size(640, 480));
  first.render({lightOf(config)}, {poseSeeing(2.0, 0.0)}, 6);
  EXPECT_EQ(cv::norm(first.render({lightOf(config)}, {pose}, 5), image, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(second.render({lightOf(config)}, {pose}, 5), image, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(second.render({lightOf(config)}, {pose}, 6), image, cv::NORM_INF), 0.0);
}

TEST(ImageRenderer, ListsEveryWrongValue) {
  RendererConfig config;
  config.reference_value = 0.0;
  config.centre_brightness = -1.0;
  config.pixels.full_well_electrons = -1.0;
  EXPECT_EQ(errorsOf(config).size(), 3U);
  EXPECT_THROW(ImageRenderer(config, darkness), std::invalid_argument);
  RendererConfig unseen;
  unseen.reference_height_m = 3.0;
  EXPECT_THROW(ImageRenderer(unseen, darkness), std::invalid_argument);
}

TEST(RoomRadiance, IsPositiveAndPeriodic) {
  for (double contrast : {0.0, 1.0}) {
    const RadianceFunction room = roomRadiance({0.1, contrast, 3});
    for (int i = 0; i < 100; ++i) {
      const double azimuth = 0.0628 * i;
      EXPECT_GT(room(azimuth, -0.1), 0.0);
      EXPECT_NEAR(room(azimuth, 0.05), room(azimuth + 2.0 * kPi, 0.05), 1e-12);
    }
  }
}

}  // namespace
}  // namespace bearing_calibration::core
