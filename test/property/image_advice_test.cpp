// The advice on focus and exposure from ray-traced images: each sentence where it is due.

#include "bearing_calibration/vision/image_advice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/vision/light_detector.h"
#include "support/rendered_observations.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

using test::Observation;

constexpr int kObservations = 12;

/// Lens and mirror are known well: else a light out of focus is one all the same.
DetectorConfig knownOptics() {
  DetectorConfig config = test::detectorOf(test::renderedRig());
  config.optics_stddev = {};
  return config;
}

/// What is said of rendered images by a detector that believes in the default rig.
class Observations {
 public:
  explicit Observations(const RendererConfig& rendered,
                        const RadianceFunction& surroundings = test::plainWall)
      : renderer_(rendered, surroundings), detector_(knownOptics()) {}

  /// The advice that stands after images of observations all around.
  std::optional<Advice> advice(double brightness) {
    AdviceTally tally;
    const std::vector<Observation> observations =
        test::randomObservations(kObservations, brightness, 51);
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const Observation& observation = observations[i];
      tally.add(
          adviceOn(renderer_.render({observation.light()}, {observation.worldFromSensor()}, i)));
    }
    return tally.take();
  }

  std::optional<Advice> adviceOn(const cv::Mat& image) {
    return adviceFor(detector_.config(), detector_.detect(image));
  }

 private:
  ImageRenderer renderer_;
  LightDetector detector_;
};

RendererConfig focusedAt(double focus_distance_m) {
  RendererConfig config = test::renderedRig();
  config.rig.focus_distance_m = focus_distance_m;
  config.rays_per_light = 1 << 13;
  return config;
}

void expectSaid(const std::optional<Advice>& advice, AdviceKind kind, const std::string& words) {
  ASSERT_TRUE(advice);
  EXPECT_EQ(advice->kind, kind) << advice->sentence;
  EXPECT_NE(advice->sentence.find(words), std::string::npos) << advice->sentence;
}

TEST(ImageAdvice, NothingToSayOfAGoodImage) {
  const auto advice = Observations(focusedAt(0.06)).advice(1.0);
  EXPECT_FALSE(advice) << advice->sentence;
}

TEST(ImageAdvice, Saturated) {
  expectSaid(Observations(focusedAt(0.06)).advice(5.7), AdviceKind::kSaturated,
             "shorten the exposure");
}

TEST(ImageAdvice, Dim) {
  // Of the 180 levels that are asked for it gets 27, with 13 of background: 4.5 times too little.
  expectSaid(Observations(focusedAt(0.06)).advice(0.15), AdviceKind::kDim, "about 4 times");
}

TEST(ImageAdvice, DimBeforeABrightWall) {
  const auto bright_wall = [](double, double) { return 0.5; };
  expectSaid(Observations(focusedAt(0.06), bright_wall).advice(0.2), AdviceKind::kDim,
             "make it stronger");
}

TEST(ImageAdvice, NothingBright) {
  expectSaid(Observations(focusedAt(0.06)).advice(0.0), AdviceKind::kNothingBright,
             "is the light on and in view");
}

TEST(ImageAdvice, TooCluttered) {
  cv::Mat sparks = cv::Mat::zeros(480, 640, CV_8U);  // every sixth pixel, none beside another
  for (int v = 0; v < sparks.rows; v += 2) {
    for (int u = 0; u < sparks.cols; u += 3) sparks.at<std::uint8_t>(v, u) = 255;
  }
  expectSaid(Observations(focusedAt(0.06)).adviceOn(sparks), AdviceKind::kTooCluttered,
             "too many bright spots");
}

TEST(ImageAdvice, BrightThingsThatAreNoLight) {
  const auto windows = [](double azimuth_rad, double elevation_rad) {
    return std::sin(3.0 * azimuth_rad) > 0.5 && elevation_rad > 0.0 ? 0.9 : 0.05;
  };
  expectSaid(Observations(focusedAt(0.06), windows).advice(0.0), AdviceKind::kNoneFits,
             "none is like the light");
}

/// A lens focused elsewhere than configured: the distance is found, and the way to turn the ring.
class WrongFocus : public testing::TestWithParam<double> {};

TEST_P(WrongFocus, IsFoundInTheSpot) {
  const RendererConfig rendered = focusedAt(GetParam());
  const double configured_m = test::defaultDetector().mirror.focus_distance_m;
  expectSaid(Observations(rendered).advice(1.0), AdviceKind::kFocus,
             GetParam() > configured_m ? "focus nearer" : "focus farther");

  ImageRenderer renderer(rendered, test::plainWall);
  LightDetector detector(test::detectorOf(rendered));
  const DetectorConfig believed = test::detectorOf(test::renderedRig());
  // The blur changes with 1 / distance: a tenth of what the aperture makes over the whole way.
  const double tolerance_per_m = 0.1 / configured_m;
  for (const Observation& observation : test::randomObservations(kObservations, 1.0, 52)) {
    const cv::Mat image =
        renderer.render({observation.light()}, {observation.worldFromSensor()}, 1);
    const DetectionResult& result = detector.detect(image);
    if (result.lights.size() != 1) continue;
    const FocusGuess guess = guessFocus(believed, result.lights.front().ellipse);
    EXPECT_NEAR(1.0 / guess.focus_distance_m, 1.0 / GetParam(), tolerance_per_m);
  }
}

INSTANTIATE_TEST_SUITE_P(Distances, WrongFocus, testing::Values(0.04, 0.09, 0.3, 1e6));

// A spot's size is measured to 6 % (expected_spot.cpp): what the search adds must be less.
TEST(GuessFocus, SearchesFinerThanASizeIsMeasured) {
  constexpr double kMeasured = 0.06;
  constexpr int kFocuses = 23;  // none of them a step of the search but the first
  const DetectorConfig believed = knownOptics();
  for (int i = 0; i < kFocuses; ++i) {
    DetectorConfig actual = believed;
    actual.mirror.focus_distance_m = kFocuses * 0.5 * believed.mirror.focus_distance_m / i;
    for (const double radius_px : {60.0, 120.0, 200.0}) {
      LightEllipse ellipse;
      ellipse.centre_px = believed.view.centre_px() + Eigen::Vector2d(radius_px, 0.0);
      ellipse.moments_px2 =
          spotSizeAt(actual, radius_px).pointStddev_px(0.0).cwiseAbs2().asDiagonal();
      EXPECT_LT(guessFocus(believed, ellipse).misfit, kMeasured)
          << actual.mirror.focus_distance_m << " m, " << radius_px << " px";
    }
  }
}

TEST(AdviceTally, HoldsWhatMostImagesSay) {
  const Advice dim{AdviceKind::kDim, "dim"}, saturated{AdviceKind::kSaturated, "saturated"};
  AdviceTally tally;
  EXPECT_FALSE(tally.take());
  tally.add(dim);
  tally.add(std::nullopt);
  tally.add(saturated);
  EXPECT_FALSE(tally.take()) << "each in a third of the images";
  tally.add(saturated);
  tally.add(std::nullopt);
  ASSERT_TRUE(tally.take());
  EXPECT_FALSE(tally.take()) << "taken already";
}

}  // namespace
}  // namespace bearing_calibration::core
