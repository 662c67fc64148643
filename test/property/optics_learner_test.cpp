// What the light's images say of lens and mirror. The ray-traced ones come from a renderer that
// shares no optics with the learner.

#include "bearing_calibration/vision/optics_learner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/rendered_observations.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

using Errors = Eigen::Array4d;  ///< of the optics' values

struct RigAndLight {
  RendererConfig rendered = test::renderedRig();
  double height_m = -0.03;
  double radius_m = 0.004;
};

/// The optics from the prior, a mirror that leans a little, and any light.
RigAndLight drawn(const DetectorConfig& config, std::mt19937* random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> part(0.0, 1.0);
  const OpticsUncertainty& stddev = config.optics_stddev;
  RigAndLight drawn;
  CameraRig& rig = drawn.rendered.rig;
  rig.focal_length_m *= std::exp(stddev.scale * normal(*random));
  rig.aperture_m *= std::exp(stddev.aperture * normal(*random));
  rig.focus_distance_m *= std::exp(stddev.focus * normal(*random));
  rig.cone_half_angle_rad += stddev.half_angle_rad * normal(*random);
  rig.axis_lean = radiansFromDegrees(0.5) * Eigen::Vector2d(normal(*random), normal(*random));
  drawn.rendered.rays_per_light = 1 << 12;
  drawn.height_m = -0.15 + 0.15 * part(*random);
  drawn.radius_m = config.light.radius_m * part(*random);
  return drawn;
}

/// Of a light at so many places around the sensor, a second apart, its distance wrong by so many
/// standard deviations each time.
std::vector<RangedSpot> detectedSpots(const RigAndLight& truth, const DetectorConfig& config,
                                      int count, unsigned seed, double distance_sigmas) {
  constexpr double kDistanceStddev = 0.01;  // relative
  ImageRenderer renderer(truth.rendered, test::plainWall);
  LightDetector detector(config);
  std::vector<RangedSpot> spots;
  int number = 0;
  for (const test::Observation& place : test::randomObservations(count, 1.0, seed)) {
    Light light = place.light();
    light.height_m = truth.height_m;
    light.radius_m = truth.radius_m;
    const Pose2 pose = place.worldFromSensor();
    const cv::Mat image = renderer.render({light}, {pose}, static_cast<std::uint64_t>(++number));
    const auto& lights = detector.detect(image).lights;
    const BearingSet bearings =
        bearingsFromLights(lights, {}, stampFromSeconds(number), config.sensor.height_px);
    constexpr double kBearingVariance_rad2 = 1e-4;
    BearingPrediction prediction{bearings.stamp, place.azimuth_rad, kBearingVariance_rad2};
    prediction.distance_m = (1.0 + kDistanceStddev * distance_sigmas) * place.distance_m;
    prediction.distance_variance_m2 = std::pow(kDistanceStddev * place.distance_m, 2);
    if (const auto spot = rangedSpot(lights, bearings, prediction)) spots.push_back(*spot);
  }
  return spots;
}

/// In standard deviations.
Errors errorsOf(const DetectorConfig& learnt, const CameraRig& truth) {
  const OpticsUncertainty& stddev = learnt.optics_stddev;
  return {std::log(learnt.mirror.focal_length_m / truth.focal_length_m) / stddev.scale,
          std::log(learnt.mirror.aperture_m / truth.aperture_m) / stddev.aperture,
          std::log(learnt.mirror.focus_distance_m / truth.focus_distance_m) / stddev.focus,
          (learnt.mirror.half_angle_rad - truth.cone_half_angle_rad) / stddev.half_angle_rad};
}

TEST(OpticsLearner, KnowsHowWellItKnowsRigsOfThePrior) {
  constexpr int kRigs = 20;
  constexpr int kImages = 24;
  constexpr int kEnough = 8;
  std::mt19937 random(91);
  std::normal_distribution<double> normal;
  const DetectorConfig config = test::shippedDetector();
  Errors squares = Errors::Zero();
  int learnt = 0;
  for (int i = 0; i < kRigs; ++i) {
    const RigAndLight truth = drawn(config, &random);
    const auto spots = detectedSpots(truth, config, kImages, random(), normal(random));
    if (spots.size() < kEnough) continue;  // the mask hides the light
    OpticsLearner learner(config);
    for (const RangedSpot& spot : spots) learner.add(spot);
    ++learnt;
    squares += errorsOf(learner.applied(config), truth.rendered.rig).square();
    EXPECT_EQ(learner.optics()[3].state, OpticsState::kLearnt) << "the half angle of rig " << i;
  }
  ASSERT_GE(learnt, 10);
  // 0.0001 and 0.9999 of chi-square with ten degrees of freedom, over these
  RecordProperty("mean_squares", testing::PrintToString((squares / learnt).transpose()));
  EXPECT_LT((squares / learnt).maxCoeff(), 3.56) << squares.transpose() / learnt;
  EXPECT_GT((squares / learnt).minCoeff(), 0.089) << squares.transpose() / learnt;
}

/// As the formulas have it: a point 30 mm under the apex.
RangedSpot idealSpot(const DetectorConfig& config, int number) {
  constexpr double kGolden_rad = 2.4;  // azimuths all around
  constexpr double kDiscVariance = 1.0 / 16.0;
  RangedSpot spot;
  spot.stamp = stampFromSeconds(number);
  spot.azimuth_rad = wrapAngle(kGolden_rad * number);
  spot.distance_m = 0.5 + 0.3 * (number % 5);
  spot.distance_variance_m2 = 1e-4;
  spot.image_radius_px = *radiusFromLight(config.mirror, {spot.distance_m, -0.03});
  const SpotBlur blur = expectedBlur(config.mirror, spot.image_radius_px, spot.distance_m);
  spot.variances_px2 = kDiscVariance * Eigen::Vector2d(std::pow(blur.tangential_diameter_px, 2),
                                                       std::pow(blur.radial_diameter_px, 2));
  spot.variances_px2.array() += kPixelVariance;
  return spot;
}

class LearntOnce : public testing::Test {
 protected:
  LearntOnce() {
    for (; number_ < 30; ++number_) learner_.add(idealSpot(config_, number_));
    learner_.hasNews();
  }

  DetectorConfig config_ = test::shippedDetector();
  OpticsLearner learner_{config_};
  int number_ = 0;
};

TEST_F(LearntOnce, ASpotOfAnotherSizeChangesNothing) {
  const DetectorConfig before = learner_.applied(config_);
  RangedSpot wrong = idealSpot(config_, number_);
  wrong.variances_px2 *= 2.5;
  EXPECT_FALSE(learner_.add(wrong));
  const DetectorConfig after = learner_.applied(config_);
  EXPECT_EQ(after.mirror.aperture_m, before.mirror.aperture_m);
  EXPECT_EQ(after.optics_stddev.focus, before.optics_stddev.focus);
  EXPECT_FALSE(learner_.hasNews());
}

TEST_F(LearntOnce, ALensThatIsTurnedIsLearntAnew) {
  ASSERT_EQ(learner_.optics()[2].state, OpticsState::kLearnt);
  DetectorConfig turned = config_;
  turned.mirror.focus_distance_m = 0.045;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(learner_.add(idealSpot(turned, number_++)));
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kConfigured);
  EXPECT_EQ(learner_.applied(config_).mirror.focus_distance_m, config_.mirror.focus_distance_m);
  EXPECT_EQ(learner_.applied(config_).optics_stddev.focus, config_.optics_stddev.focus);
  EXPECT_TRUE(learner_.hasNews());
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(learner_.add(idealSpot(turned, number_++)));
  const DetectorConfig learnt = learner_.applied(config_);
  EXPECT_LT(learnt.mirror.focus_distance_m, 0.055);
  EXPECT_NEAR(std::log(learnt.mirror.focus_distance_m / turned.mirror.focus_distance_m), 0.0,
              3.0 * learnt.optics_stddev.focus);
}

TEST_F(LearntOnce, ALightThatIsMissedForLongIsLookedForAsConfigured) {
  for (int i = 0; i < 19; ++i) learner_.miss(stampFromSeconds(number_++));
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kLearnt);
  learner_.miss(stampFromSeconds(number_ - 1));  // the same moment
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kLearnt);
  learner_.miss(stampFromSeconds(number_++));
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kConfigured);
}

// The calibration has ended or is paused: what it said last is no reason to miss the light.
TEST_F(LearntOnce, NoLightIsMissedByAnOldPrediction) {
  const auto seeNothing = [&](double age_s) {
    BearingSet nothing;
    nothing.stamp = stampFromSeconds(number_++);
    BearingPrediction prediction;
    prediction.stamp = nothing.stamp - durationFromSeconds(age_s);
    learner_.see({}, nothing, prediction);
  };
  for (int i = 0; i < 40; ++i) seeNothing(1.0);
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kLearnt);
  for (int i = 0; i < 20; ++i) seeNothing(0.1);
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kConfigured);
}

TEST_F(LearntOnce, WhatIsSeenInBetweenCounts) {
  for (int i = 0; i < 19; ++i) learner_.miss(stampFromSeconds(number_++));
  EXPECT_TRUE(learner_.add(idealSpot(config_, number_++)));
  for (int i = 0; i < 19; ++i) learner_.miss(stampFromSeconds(number_++));
  EXPECT_EQ(learner_.optics()[2].state, OpticsState::kLearnt);
}

TEST(OpticsLearner, BeginsWithWhatIsConfiguredAndHasNewsOnce) {
  const DetectorConfig config = test::shippedDetector();
  OpticsLearner learner(config);
  EXPECT_FALSE(learner.hasNews());
  EXPECT_EQ(learner.optics()[1].state, OpticsState::kConfigured);
  EXPECT_EQ(learner.optics()[1].value, config.mirror.aperture_m);
  EXPECT_EQ(learner.learntValues(), 0);
  EXPECT_TRUE(learner.add(idealSpot(config, 1)));
  EXPECT_EQ(learner.optics()[0].state, OpticsState::kLearning);
  EXPECT_TRUE(learner.hasNews());
  EXPECT_FALSE(learner.hasNews());
}

TEST(OpticsLearner, ImagesOfOneMomentAreOne) {
  const DetectorConfig config = test::shippedDetector();
  OpticsLearner learner(config);
  RangedSpot spot = idealSpot(config, 1);
  EXPECT_TRUE(learner.add(spot));
  spot.stamp += durationFromSeconds(0.4);
  EXPECT_FALSE(learner.add(spot));
  spot.stamp += durationFromSeconds(0.2);
  EXPECT_TRUE(learner.add(spot));
}

TEST(OpticsLearner, OpticsThatAreKnownStay) {
  DetectorConfig config = test::shippedDetector();
  DetectorConfig other = config;
  other.mirror.aperture_m *= 1.03;
  config.optics_stddev = {};
  OpticsLearner learner(config);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(learner.add(idealSpot(other, i)));
  EXPECT_FALSE(learner.hasNews());
  EXPECT_EQ(learner.applied(config).mirror.aperture_m, config.mirror.aperture_m);
  for (const LearntOptics& each : learner.optics())
    EXPECT_EQ(each.state, OpticsState::kConfigured) << each.parameter;
}

// What the software adds to a spot's size tells nothing of the lens.
TEST(OpticsLearner, TheSoftwaresDefocusIsNotOfTheLens) {
  DetectorConfig config = test::shippedDetector();
  config.defocus_sigma_px = 3.0;
  OpticsLearner learner(config);
  for (int i = 0; i < 30; ++i) {
    RangedSpot spot = idealSpot(config, i);
    spot.variances_px2.array() += std::pow(config.defocus_sigma_px, 2);
    EXPECT_TRUE(learner.add(spot)) << i;
  }
  const DetectorConfig learnt = learner.applied(config);
  EXPECT_NEAR(std::log(learnt.mirror.aperture_m / config.mirror.aperture_m), 0.0,
              3.0 * learnt.optics_stddev.aperture);
  EXPECT_NEAR(std::log(learnt.mirror.focus_distance_m / config.mirror.focus_distance_m), 0.0,
              3.0 * learnt.optics_stddev.focus);
}

TEST(OpticsLearner, NeedsAMirror) {
  DetectorConfig config = test::shippedDetector();
  config.mirror_kind = MirrorKind::kOther;
  EXPECT_THROW(OpticsLearner learner(config), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
