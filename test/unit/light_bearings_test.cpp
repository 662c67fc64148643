#include "bearing_calibration/vision/light_bearings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/search_region.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

const Stamp kImageStamp = stampFromSeconds(100.0);

Detection lightInRow(double row, double probability) {
  Detection light;
  light.ellipse.centre_px = {0.0, row};
  light.bearing.azimuth_variance_rad2 = 1e-6;
  light.bearing.probability = probability;
  return light;
}

TEST(LightBearings, TheStampIsTheRowsMidExposure) {
  const ShutterConfig config{0.004, 50e-6, 1.0};
  const BearingSet set = bearingsFromLights({lightInRow(200.5, 0.9)}, config, kImageStamp, 480);
  EXPECT_EQ((set.stamp - kImageStamp).count(), 4000000 + 10025000);
  ASSERT_EQ(set.candidates.size(), 1u);
  EXPECT_DOUBLE_EQ(set.candidates.front().azimuth_variance_rad2, 1e-6);
}

TEST(LightBearings, WithoutALightItIsTheMiddleRows) {
  const BearingSet set = bearingsFromLights({}, {-0.01, 1e-3, 1.0}, kImageStamp, 101);
  EXPECT_EQ((set.stamp - kImageStamp).count(), -10000000 + 50000000);
  EXPECT_TRUE(set.candidates.empty());
}

TEST(LightBearings, ALessLikelyLightPaysForItsOtherRow) {
  const ShutterConfig config{0.0, 50e-6, 2.0};
  const BearingSet set = bearingsFromLights({lightInRow(300.0, 0.5), lightInRow(100.0, 0.9)},
                                            config, kImageStamp, 480);
  EXPECT_EQ((set.stamp - kImageStamp).count(), 5000000);
  EXPECT_DOUBLE_EQ(set.candidates[1].azimuth_variance_rad2, 1e-6);
  const double seconds_apart = 200.0 * 50e-6;
  EXPECT_DOUBLE_EQ(set.candidates[0].azimuth_variance_rad2,
                   1e-6 + std::pow(2.0 * seconds_apart, 2));
}

/// What clipping adds to the azimuth's variance of a disc, 100 px from the mirror's centre.
double clippingOf(double radius_px) {
  DetectorConfig config = test::defaultDetector();
  config.light.brightness_spread = 0.0;
  LightEllipse disc;
  disc.centre_px = config.view.centre_px() + Eigen::Vector2d(100.0, 0.0);
  disc.moments_px2 = radius_px * radius_px / 4.0 * Eigen::Matrix2d::Identity();
  const double unclipped = bearingOf(disc, {}, {}, nullptr, config)->azimuth_variance_rad2;
  disc.saturated_fraction = 1.0;
  return bearingOf(disc, {}, {}, nullptr, config)->azimuth_variance_rad2 - unclipped;
}

// So many pixels on the outline as the radius is long, each of the square of it in the moment,
// which is divided by the area: as 1 / radius.
TEST(LightBearings, ClippingHalvesWithTwiceTheRadius) {
  EXPECT_NEAR(clippingOf(8.0) / clippingOf(4.0), 0.5, 1e-6);
  EXPECT_GT(clippingOf(8.0), 0.0);
}

// Where an image shows an unevenly lit lamp in parts, its centre may be that of either.
TEST(LightBearings, ARefusedSpotBesideTheLightMakesItLessCertain) {
  const DetectorConfig config = test::defaultDetector();
  constexpr double kFromCentre_px = 100.0;
  constexpr double kStddev_px = 4.0;
  LightEllipse light;
  light.centre_px = config.view.centre_px() + Eigen::Vector2d(kFromCentre_px, 0.0);
  light.moments_px2 = kStddev_px * kStddev_px * Eigen::Matrix2d::Identity();
  Search search;
  search.thresholds = 2;
  const auto variance_rad2 = [&](double apart_px) {
    Detection spot;
    spot.ellipse = light;
    spot.ellipse.centre_px.y() += apart_px;
    spot.rejection = Rejection::kUnlikely;
    return bearingOf(light, search, {spot}, nullptr, config)->azimuth_variance_rad2;
  };
  const double alone_rad2 = bearingOf(light, search, {}, nullptr, config)->azimuth_variance_rad2;
  const double within_px = 1.9 * kStddev_px;
  EXPECT_NEAR(variance_rad2(within_px) - alone_rad2, std::pow(within_px / kFromCentre_px, 2), 1e-9);
  EXPECT_EQ(variance_rad2(2.1 * kStddev_px), alone_rad2) << "not a part of it";
  // more than there was has been taken for its background
  Detection far;
  far.ellipse.centre_px = light.centre_px + Eigen::Vector2d(50.0, 50.0);
  far.ellipse.moments_px2 = -1.0 * Eigen::Matrix2d::Identity();
  far.rejection = Rejection::kTangentialSize;
  EXPECT_EQ(bearingOf(light, search, {far}, nullptr, config)->azimuth_variance_rad2, alone_rad2);
}

// Where a bright area was taken away, by 0.3 px in whatever direction (detection.md).
TEST(LightBearings, AreLessCertainBesideABrightAreaThatWasTakenAway) {
  const DetectorConfig config = test::defaultDetector();
  constexpr double kFromCentre_px = 100.0;
  LightEllipse light;
  light.centre_px = config.view.centre_px() + Eigen::Vector2d(kFromCentre_px, 0.0);
  light.moments_px2 = 4.0 * Eigen::Matrix2d::Identity();
  Search opened;
  opened.opened = true;
  const Bearing beside = *bearingOf(light, opened, {}, nullptr, config);
  const Bearing alone = *bearingOf(light, {}, {}, nullptr, config);
  EXPECT_NEAR(beside.azimuth_variance_rad2 - alone.azimuth_variance_rad2,
              std::pow(0.3 / kFromCentre_px, 2), 1e-12);
  EXPECT_NEAR(beside.image_radius_variance_px2 - alone.image_radius_variance_px2, 0.3 * 0.3, 1e-9);
}

SearchConfig search() {
  SearchConfig config;
  config.use = true;
  config.sigmas = 3.0;
  config.margin_rad = 0.1;
  config.max_age_s = 0.2;
  config.max_turn_rate_radps = 1.0;
  config.max_radius_rate_pxps = 80.0;
  return config;
}

TEST(SearchRegion, GrowsWithTheUncertaintyAndTheAge) {
  const BearingPrediction prediction{kImageStamp, 4.0, 0.05 * 0.05};
  const auto now = searchRegion(search(), prediction, std::nullopt, kImageStamp);
  ASSERT_TRUE(now);
  EXPECT_NEAR(now->sector.centre_rad, 4.0 - 2.0 * kPi, 1e-12);
  EXPECT_NEAR(now->sector.half_width_rad, 0.1 + 3.0 * 0.05, 1e-12);
  EXPECT_FALSE(now->place);
  for (double age : {-0.1, 0.1}) {
    const auto later =
        searchRegion(search(), prediction, std::nullopt, kImageStamp + durationFromSeconds(age));
    ASSERT_TRUE(later);
    EXPECT_NEAR(later->sector.half_width_rad, 0.25 + 0.1, 1e-9);
  }
}

TEST(SearchRegion, AnImageRadiusThatWasSeenMakesItAPlace) {
  const BearingPrediction prediction{kImageStamp, 4.0, 0.05 * 0.05};
  const SeenRadius seen{kImageStamp - durationFromSeconds(0.1), 150.0, 0.25};
  const auto region = searchRegion(search(), prediction, seen, kImageStamp);
  ASSERT_TRUE(region && region->place);
  EXPECT_NEAR(region->place->centre.azimuth_rad, 4.0 - 2.0 * kPi, 1e-12);
  EXPECT_EQ(region->place->centre.image_radius_px, 150.0);
  EXPECT_NEAR(region->place->half_width_rad, 3.0 * 0.05, 1e-12);
  EXPECT_NEAR(region->place->half_height_px, 3.0 * 0.5 + 0.1 * 80.0, 1e-9);
  const SeenRadius long_ago{kImageStamp - durationFromSeconds(0.21), 150.0, 0.25};
  const auto sector = searchRegion(search(), prediction, long_ago, kImageStamp);
  ASSERT_TRUE(sector);
  EXPECT_FALSE(sector->place);
}

DetectorConfig mirrorInVga() {
  DetectorConfig config;
  config.sensor.width_px = 640;
  config.sensor.height_px = 480;
  config.view = {319.5, 239.5, 1};
  config.mirror = test::defaultMirror();
  config.mask.outer_radius_px = 250.0;
  config.light.min_distance_m = 0.25;
  config.light.max_distance_m = 10.0;
  return config;
}

// A light in the mirror's very middle has an azimuth, too: that of its pixel's rounding.
TEST(SearchRegion, AtTheMirrorsCentreThereIsABox) {
  const DetectorConfig config = mirrorInVga();
  const ExpectedPlace place{{0.0, 0.5}, 0.1, 5.0};
  const cv::Rect box = boxAround(place, ExpectedSpot(config), config);
  EXPECT_GE(box.y, 0);
  EXPECT_LT(box.y, 239);
  EXPECT_GT(box.br().y, 240);
  EXPECT_GE(box.x, 0);
  EXPECT_LT(box.x, 319);
  EXPECT_GT(box.br().x, 320);
  EXPECT_LE(box.br().x, config.sensor.width_px);
}

TEST(SearchRegion, ABoxEndsWithTheImage) {
  const DetectorConfig config = mirrorInVga();
  const ExpectedSpot expected(config);
  EXPECT_EQ(boxAround({{235.0, -0.5 * kPi}, 0.1, 5.0}, expected, config).br().y, 480);
  EXPECT_EQ(boxAround({{235.0, 0.5 * kPi}, 0.1, 5.0}, expected, config).y, 0);
  EXPECT_EQ(boxAround({{315.0, 0.0}, 0.1, 5.0}, expected, config).br().x, 640);
  EXPECT_EQ(boxAround({{315.0, kPi}, 0.1, 5.0}, expected, config).x, 0);
}

// Of a lamp whose size and distance are known, all that is not is the lens: a blur of 0 to 0.5 px,
// whose variance adds to the others.
TEST(SpotSize, TheLensAddsItsBlurToALightOfKnownSize) {
  DetectorConfig config = mirrorInVga();
  config.light.min_distance_m = config.light.max_distance_m = 2.0;
  config.light.radius_m = config.light.min_radius_m = 0.01;
  for (const double radius_px : {20.0, 100.0, 180.0}) {
    const SpotSize size = spotSizeAt(config, radius_px);
    const Eigen::Array2d added_px2 =
        size.most_stddev_px.array().square() - size.least_stddev_px.array().square();
    EXPECT_LT((added_px2 - 0.25).abs().maxCoeff(), 1e-12) << radius_px;
  }
}

// A lamp close beside the mirror, and optics that are known badly: by some of those that are
// thought possible the mirror's rim would show what is inside of it.
TEST(SpotSize, OpticsThatPutTheLightInsideTheMirrorAreNotPossible) {
  DetectorConfig config = mirrorInVga();
  config.light.min_distance_m = 0.036;
  config.light.max_distance_m = 0.042;
  for (const double scale_stddev : {0.3, 0.5}) {
    config.optics_stddev.scale = scale_stddev;
    const SpotSize size = spotSizeAt(config, rimRadiusPx(config.mirror));
    EXPECT_TRUE(size.log_covariance.allFinite()) << scale_stddev;
  }
}

/// A camera whose lights are wider by a tenth of a pixel for each of the image radius; of a point,
/// one and a half times as long as wide.
ExpectedSpot wideningLights(const DetectorConfig& config, int end_px) {
  std::vector<SpotSize> sizes;
  for (int image_radius_px = 0; image_radius_px <= end_px; ++image_radius_px) {
    SpotSize& size = sizes.emplace_back();
    size.least_stddev_px.setConstant(1.0 + 0.1 * image_radius_px);
    size.most_stddev_px = 2.0 * size.least_stddev_px;
    size.log_point = (size.least_stddev_px.array() * Eigen::Array2d(1.0, 1.5)).log();
    size.log_covariance.setZero();
  }
  return {sizes, 60.0, config};
}

TEST(ExpectedSpot, IsThatOfAnyCamerasOptics) {
  DetectorConfig config;
  config.view = {100.0, 50.0, 1};
  config.mask.inner_radius_px = 10.0;
  const ExpectedSpot expected = wideningLights(config, 70);
  EXPECT_NEAR(expected.at({100.0, 16.6}).least_stddev_px(0), 1.0 + 3.3, 1e-12);
  EXPECT_NEAR(expected.at({103.4, 54.5}).least_stddev_px(1), 1.0 + 0.6, 1e-12);
  EXPECT_NEAR(expected.at({600.0, 50.0}).least_stddev_px(0), 1.0 + 7.0, 1e-12) << "the mask's end";
  EXPECT_TRUE(expected.mayStandAt({159.9, 50.0}));
  EXPECT_FALSE(expected.mayStandAt({100.0, 110.1}));
  EXPECT_NEAR(expected.area_px().low, 4.0 * kPi * std::pow(2.0, 2), 1e-9);
  EXPECT_NEAR(expected.area_px().high, 4.0 * kPi * std::pow(16.0, 2), 1e-9);
  EXPECT_NEAR(expected.largestPointStddev_px(), 1.5 * 8.0, 1e-9);
}

TEST(SearchRegion, ABoxHoldsTheLightWhereverItMayBe) {
  DetectorConfig config = mirrorInVga();
  config.view = {320.0, 240.0, 1};
  const ExpectedSpot expected = wideningLights(config, 80);
  const ExpectedPlace place{{50.0, 0.0}, 0.1, 5.0};
  const double outward_px = 5.0 + 0.5 * 50.0 * 0.1 * 0.1 + 2.0 * 1.5 * 6.0 + 2.0;  // 25.25
  const double sideways_px = 50.0 * 0.1 + 2.0 * 6.0 + 2.0;                         // 19
  const cv::Rect box = boxAround(place, expected, config);
  EXPECT_EQ(box.x, std::floor(370.0 - outward_px));
  EXPECT_EQ(box.br().x, std::floor(371.0 + outward_px));
  EXPECT_EQ(box.y, 240.0 - sideways_px);
  EXPECT_EQ(box.br().y, 241.0 + sideways_px);
}

TEST(SearchRegion, TheRadiusIsThatOfTheCandidateNearestToThePrediction) {
  const BearingPrediction prediction{kImageStamp, 3.1, 0.01};
  EXPECT_FALSE(seenRadius({kImageStamp, {}}, prediction));
  const Bearing beyond_pi{-3.1, 1e-6, 150.0, 0.25};
  const Bearing farther{2.9, 1e-6, 90.0, 0.5};
  const auto seen = seenRadius({kImageStamp, {farther, beyond_pi}}, prediction);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->stamp, kImageStamp);
  EXPECT_EQ(seen->radius_px, 150.0);
  EXPECT_EQ(seen->radius_variance_px2, 0.25);
}

TEST(SearchRegion, AUselessPredictionMeansToSearchEverywhere) {
  const BearingPrediction good{kImageStamp, 0.0, 0.01};
  EXPECT_TRUE(searchRegion(search(), good, std::nullopt, kImageStamp));
  SearchConfig off = search();
  off.use = false;
  EXPECT_FALSE(searchRegion(off, good, std::nullopt, kImageStamp));
  EXPECT_FALSE(searchRegion(search(), good, std::nullopt, kImageStamp + durationFromSeconds(0.21)));
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(searchRegion(search(), {kImageStamp, 0.0, 1.0}, std::nullopt, kImageStamp));
  EXPECT_FALSE(searchRegion(search(), {kImageStamp, kNaN, 0.01}, std::nullopt, kImageStamp));
  EXPECT_FALSE(searchRegion(search(), {kImageStamp, 0.0, kNaN}, std::nullopt, kImageStamp));
  EXPECT_FALSE(searchRegion(search(), {kImageStamp, 0.0, -0.01}, std::nullopt, kImageStamp));
}

TEST(SearchRegion, ValidateNamesEveryWrongValue) {
  EXPECT_TRUE(errorsOf(search()).empty());
  SearchConfig config = search();
  config.margin_rad = 0.0;
  config.max_radius_rate_pxps = -1.0;
  EXPECT_EQ(errorsOf(config).size(), 2u);
  EXPECT_EQ(errorsOf(ShutterConfig{40.0, std::nan(""), -1.0}).size(), 3u);
}

}  // namespace
}  // namespace bearing_calibration::core
