#include "bearing_calibration/input/scan_bearings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/input/point_bearing.h"
#include "support/ray_traced_scan.h"

namespace bearing_calibration::core {
namespace {

using testing::placeAt;
using testing::Post;
using testing::tracedScan;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const ScanLightConfig kPost{0.0, 0.2, 0.03, 0.2};
const ScanLightConfig kReflector{100.0, 0.0, 0.03, 0.2};

double azimuthOf(const ScanLight& light) {
  return std::atan2(light.position_m.y(), light.position_m.x());
}

// An edge lies anywhere between two rays, so that the middle of two is off by half of a spacing at
// most; over many directions its variance is the stated one.
TEST(ScanLights, APostIsWhereItIs) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> direction(-3.0, 3.0);
  std::uniform_real_distribution<double> distance(0.8, 4.0);
  constexpr int kPosts = 2000;
  double sum2 = 0.0;
  LaserScan scan;
  for (int i = 0; i < kPosts; ++i) {
    const Post post{placeAt(distance(random), direction(random)), 0.05};
    scan = tracedScan({post});
    const auto lights = lightsInScan(scan, kPost);
    ASSERT_EQ(lights.size(), 1U) << post.centre_m.transpose();
    const double truth = std::atan2(post.centre_m.y(), post.centre_m.x());
    const double error = wrapAngle(azimuthOf(lights.front()) - truth);
    EXPECT_LE(std::abs(error), 0.5 * scan.ray_spacing_rad + 1e-9);
    EXPECT_NEAR(lights.front().position_m.norm(), post.centre_m.norm() - 0.04, 0.02);
    sum2 += error * error;
  }
  EXPECT_NEAR(sum2 / kPosts / edgeVariance(scan), 1.0, 5.0 * std::sqrt(2.0 / kPosts));
}

TEST(ScanLights, HaveTheStampOfTheirRays) {
  const double azimuth = 1.0;
  const LaserScan scan = tracedScan({{placeAt(2.0, azimuth), 0.05}});
  const auto lights = lightsInScan(scan, kPost);
  ASSERT_EQ(lights.size(), 1U);
  // The scan begins at -pi and turns once in 0.1 s.
  EXPECT_NEAR(secondsFromDuration(lights.front().stamp - scan.stamp),
              0.1 * (azimuth + kPi) / (2.0 * kPi), 1e-4);
}

TEST(ScanLights, OfAScannerThatTurnsClockwise) {
  LaserScan scan = tracedScan({{placeAt(2.0, 1.0), 0.05}});
  scan.first_ray_rad = -scan.first_ray_rad;  // as mounted upside down
  scan.ray_spacing_rad = -scan.ray_spacing_rad;
  const auto lights = lightsInScan(scan, kPost);
  ASSERT_EQ(lights.size(), 1U);
  EXPECT_NEAR(azimuthOf(lights.front()), -1.0, 0.5 * std::abs(scan.ray_spacing_rad));
}

TEST(ScanLights, ArePostsOfTheRightWidthOnly) {
  const Post thin{placeAt(1.0, -1.0), 0.004};
  const Post right{placeAt(1.5, 0.0), 0.05};
  const Post wide{placeAt(2.0, 1.0), 0.3};
  const auto lights = lightsInScan(tracedScan({thin, right, wide}), kPost);
  ASSERT_EQ(lights.size(), 1U);
  EXPECT_NEAR(azimuthOf(lights.front()), 0.0, 0.01);
}

TEST(ScanLights, AreNotPostsThatSomethingNearerHides) {
  const Post post{placeAt(2.0, 0.0), 0.05};
  EXPECT_EQ(lightsInScan(tracedScan({post, {placeAt(1.0, 0.03), 0.02}}), kPost).size(), 1U);
  const auto lights = lightsInScan(tracedScan({post, {placeAt(1.0, 0.03), 0.02}}), kPost);
  EXPECT_NEAR(azimuthOf(lights.front()), 0.03, 0.01);  // the nearer one, which is whole
}

TEST(ScanLights, AreNotWhatTheEndsOfTheScanCutOff) {
  EXPECT_TRUE(lightsInScan(tracedScan({{placeAt(2.0, kPi), 0.1}}), kPost).empty());
  EXPECT_TRUE(lightsInScan(tracedScan({{placeAt(2.0, kPi), 0.1, 200.0F}}), kReflector).empty());
}

TEST(ScanLights, AreSeenBeforeNothing) {
  LaserScan scan = tracedScan({{placeAt(2.0, 0.5), 0.05}});
  for (const float nothing : {std::numeric_limits<float>::infinity(), 0.0F,
                              std::numeric_limits<float>::quiet_NaN(), 40.0F}) {
    for (float& range : scan.ranges_m) {
      if (!(range < 3.0F)) range = nothing;
    }
    EXPECT_EQ(lightsInScan(scan, kPost).size(), 1U) << nothing;
  }
}

TEST(ScanLights, AreReflectorsInAWall) {
  LaserScan scan = tracedScan({});
  const std::size_t first = 400;
  for (std::size_t i = first; i < first + 3; ++i) scan.intensities[i] = 200.0F;
  scan.intensities[first + 1] = 500.0F;
  scan.intensities[first + 2] = 300.0F;
  scan.intensities[100] = kNaN;
  const auto lights = lightsInScan(scan, kReflector);
  ASSERT_EQ(lights.size(), 1U);
  const double middle = static_cast<double>(first) + (0.0 * 200 + 1.0 * 500 + 2.0 * 300) / 1000.0;
  EXPECT_NEAR(azimuthOf(lights.front()), scan.first_ray_rad + middle * scan.ray_spacing_rad, 1e-9);
  EXPECT_TRUE(lightsInScan(scan, kPost).empty());
}

TEST(ScanLights, AreBrightPostsWhereBothAreAskedFor) {
  ScanLightConfig both = kPost;
  both.min_intensity = kReflector.min_intensity;
  const Post dull{placeAt(1.0, -1.0), 0.05};
  const Post bright{placeAt(2.0, 1.0), 0.05, 200.0F};
  const auto lights = lightsInScan(tracedScan({dull, bright}), both);
  ASSERT_EQ(lights.size(), 1U);
  EXPECT_NEAR(azimuthOf(lights.front()), 1.0, 0.01);
}

TEST(ScanLights, ComeWithTheOneOfMostRaysFirst) {
  const auto lights =
      lightsInScan(tracedScan({{placeAt(3.0, -1.0), 0.05}, {placeAt(1.0, 1.0), 0.05}}), kPost);
  ASSERT_EQ(lights.size(), 2U);
  EXPECT_NEAR(azimuthOf(lights.front()), 1.0, 0.01);
  EXPECT_GT(lights[0].rays, lights[1].rays);
}

TEST(Scans, ThatCannotBeUsedAreNamed) {
  const LaserScan good = tracedScan({});
  EXPECT_EQ(whyUnusable(good, kReflector), "");
  const auto expect = [&](const char* name, auto spoil) {
    LaserScan scan = good;
    spoil(scan);
    EXPECT_EQ(whyUnusable(scan, kReflector), name);
  };
  expect("scan without rays", [](LaserScan& scan) { scan.ranges_m.clear(); });
  expect("scan without intensities", [](LaserScan& scan) { scan.intensities.clear(); });
  const char* angles = "scan's angles are no part of a turn";
  expect(angles, [](LaserScan& scan) { scan.ray_spacing_rad = 0.0; });
  expect(angles, [](LaserScan& scan) { scan.ray_spacing_rad = kNaN; });
  expect(angles, [](LaserScan& scan) { scan.ray_spacing_rad = 0.5; });  // in degrees
  expect(angles, [](LaserScan& scan) { scan.first_ray_rad = kNaN; });
  expect(angles, [](LaserScan& scan) { scan.ray_spacing_rad *= 1.15; });
  LaserScan overlapping = good;
  overlapping.ray_spacing_rad *= 1.05;
  EXPECT_EQ(whyUnusable(overlapping, kReflector), "");
  expect("scan's time_increment", [](LaserScan& scan) { scan.ray_period_s = -1e-4; });
  expect("scan's time_increment", [](LaserScan& scan) { scan.ray_period_s = kNaN; });
  expect("scan's range_min and range_max", [](LaserScan& scan) { scan.most_range_m = 0.0; });
}

TEST(TimedBearings, HaveTheStampOfTheExpectedOne) {
  TimedBearing first{{}, stampFromSeconds(10.0)};
  TimedBearing second{{}, stampFromSeconds(10.04)};
  first.bearing.azimuth_rad = -2.0;
  second.bearing.azimuth_rad = 3.0;
  first.bearing.azimuth_variance_rad2 = second.bearing.azimuth_variance_rad2 = 1e-4;
  const double apart_rad2 = std::pow(1.5 * 0.04, 2);

  BearingSet set = atOneMoment({first, second}, std::nullopt);
  EXPECT_EQ(set.stamp, first.stamp);
  EXPECT_EQ(set.candidates[0].azimuth_variance_rad2, 1e-4);
  EXPECT_NEAR(set.candidates[1].azimuth_variance_rad2, 1e-4 + apart_rad2, 1e-12);

  BearingPrediction prediction{stampFromSeconds(9.9), -3.1, 1e-4};  // beside 3.0
  set = atOneMoment({first, second}, prediction);
  EXPECT_EQ(set.stamp, second.stamp);
  EXPECT_NEAR(set.candidates[0].azimuth_variance_rad2, 1e-4 + apart_rad2, 1e-12);
  EXPECT_EQ(set.candidates[1].azimuth_variance_rad2, 1e-4);

  prediction.stamp = stampFromSeconds(9.0);  // of long ago
  EXPECT_EQ(atOneMoment({first, second}, prediction).stamp, first.stamp);
}

TEST(PointBearings, AreThoseOfTheSensorsPlane) {
  const Bearing bearing = bearingOfPoint({-1.0, 1.0, std::sqrt(2.0)}, 0.02);
  EXPECT_NEAR(bearing.azimuth_rad, 0.75 * kPi, 1e-12);
  EXPECT_NEAR(bearing.elevation_rad, 0.25 * kPi, 1e-12);
  EXPECT_DOUBLE_EQ(bearing.azimuth_variance_rad2, 4e-4);
  EXPECT_DOUBLE_EQ(bearing.elevation_variance_rad2, 4e-4);
}

TEST(PointBearings, PointsThatAreNoneAreNamed) {
  EXPECT_EQ(whyNoPoint({1.0, 0.0, 0.0}), nullptr);
  EXPECT_STREQ(whyNoPoint({1.0, kNaN, 0.0}), "point not finite");
  EXPECT_STREQ(whyNoPoint({std::numeric_limits<double>::infinity(), 0.0, 0.0}), "point not finite");
  EXPECT_STREQ(whyNoPoint({0.0, 0.0, 0.0}), "point at the origin");
  EXPECT_EQ(whyNoAzimuth({0.0, -0.1, 5.0}), nullptr);
  EXPECT_STREQ(whyNoAzimuth({0.0, 0.0, 1.0}), "point on the sensor's z axis");
  EXPECT_STREQ(whyNoAzimuth({kNaN, 1.0, 0.0}), "point not finite");
}

TEST(ScanBearings, AreThoseOfTheSensorsFrame) {
  constexpr double kTurn_rad = 0.4;
  const LaserScan scan = tracedScan({{placeAt(2.0, -1.0), 0.05}});
  const Eigen::Isometry3d sensor_from_scan(Eigen::AngleAxisd(kTurn_rad, Eigen::Vector3d::UnitZ()));
  const auto bearings = [&](const Eigen::Isometry3d& transform) {
    return bearingsInScan(scan, kPost, transform, 0.02, std::nullopt);
  };
  const BearingSet own = bearings(Eigen::Isometry3d::Identity());
  const BearingSet turned = bearings(sensor_from_scan);
  ASSERT_EQ(own.candidates.size(), 1U);
  const Bearing& bearing = turned.candidates.at(0);
  EXPECT_NEAR(bearing.azimuth_rad, own.candidates[0].azimuth_rad + kTurn_rad, 1e-9);
  EXPECT_NEAR(bearing.azimuth_variance_rad2, 0.02 * 0.02 + edgeVariance(scan), 1e-12);
  EXPECT_FALSE(elevationOf(bearing));
  EXPECT_EQ(turned.stamp, own.stamp);
}

// A direction is the same from wherever it is seen: here from behind the sensor, turned to the
// left.
TEST(ScanBearings, HaveAFieldOfViewThatTurnsWithTheScannerButDoesNotMove) {
  LaserScan scan = tracedScan({});
  scan.first_ray_rad = -0.5;
  scan.ray_spacing_rad = 1.0 / static_cast<double>(scan.ranges_m.size() - 1);
  const Eigen::Isometry3d sensor_from_scan =
      Eigen::Translation3d(-1.0, 0.3, 0.0) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ());
  const FieldOfView view = bearingsInScan(scan, kPost, sensor_from_scan, 0.02, std::nullopt).view;
  EXPECT_NEAR(view.centre_rad, 0.4, 1e-9);
  EXPECT_NEAR(view.width_rad, 1.0, 1e-9);
}

TEST(LaserScan, SeesWhereItsRaysGo) {
  LaserScan scan;
  scan.first_ray_rad = -2.0;
  scan.ray_spacing_rad = 0.01;
  scan.ranges_m.resize(301);  // to 1 rad
  EXPECT_NEAR(viewOf(scan).centre_rad, -0.5, 1e-12);
  EXPECT_NEAR(viewOf(scan).width_rad, 3.0, 1e-12);
  scan.ray_spacing_rad = -0.01;  // clockwise, to -5 rad
  EXPECT_NEAR(viewOf(scan).centre_rad, -3.5 + 2.0 * kPi, 1e-12);
  EXPECT_NEAR(viewOf(scan).width_rad, 3.0, 1e-12);
}

// Some scanners repeat the first ray at the end, some do not.
TEST(LaserScan, OfAWholeTurnSeesAllAround) {
  LaserScan scan;
  for (const std::size_t rays : {359U, 360U, 361U, 362U}) {
    scan.ray_spacing_rad = 2.0 * kPi / 360.0;
    scan.ranges_m.resize(rays);
    EXPECT_FALSE(viewOf(scan).isLimited()) << rays;
  }
  scan.ranges_m.resize(355);
  EXPECT_TRUE(viewOf(scan).isLimited());
}

}  // namespace
}  // namespace bearing_calibration::core
