// The detector on ray-traced images: the renderer shares no optics with it. The figures asked for
// are the package's own aims (detection.md).

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "support/rendered_series.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

using test::BearingErrors;
using test::RenderedSeries;

constexpr double kUnbounded = 1e9;

/// What is asked of a series.
struct Aim {
  const char* series;
  int images;
  double max_rmse_deg;
  double max_bias_deg;
  double min_nees;  ///< normalised error squared: 1 when the variance is right
  double max_nees;
  double min_found;  ///< part of the images
};

void PrintTo(const Aim& aim, std::ostream* stream) { *stream << aim.series; }

constexpr unsigned kSeed = 31;

BearingErrors expectAim(const Aim& aim) {
  const BearingErrors errors = test::errorsOf(test::renderedSeries(aim.series), aim.images, kSeed);
  testing::Test::RecordProperty("rmse_deg", std::to_string(errors.rmse_deg()));
  testing::Test::RecordProperty("bias_deg", std::to_string(errors.bias_deg()));
  testing::Test::RecordProperty("nees", std::to_string(errors.nees()));
  EXPECT_GE(errors.found, aim.min_found * aim.images);
  EXPECT_LT(errors.rmse_deg(), aim.max_rmse_deg);
  EXPECT_LT(std::abs(errors.bias_deg()), aim.max_bias_deg);
  EXPECT_LT(errors.nees(), aim.max_nees);
  EXPECT_GT(errors.nees(), aim.min_nees);
  return errors;
}

class RenderedLight : public testing::TestWithParam<Aim> {};

TEST_P(RenderedLight, IsReadAsWellAsAskedForAndTheVarianceKnowsIt) { expectAim(GetParam()); }

// A near ring may look like no ellipse. A mosaic's variance leaves out what its interpolation does
// to the spot's outline, 0.01 px, which is far below any real rig's alignment.
INSTANTIATE_TEST_SUITE_P(
    Series, RenderedLight,
    testing::Values(Aim{"saturated", 60, 0.02, kUnbounded, 0.0, 1.3, 1.0},
                    Aim{"ring, 10 % unequal", 100, kUnbounded, kUnbounded, 0.4, 1.3, 0.98},
                    Aim{"ring, 30 % unequal", 100, kUnbounded, kUnbounded, 0.4, 1.3, 0.98},
                    Aim{"motion blur", 60, 0.01, 0.001, 0.0, 1.3, 1.0},
                    Aim{"rolling shutter", 60, 0.005, 0.001, 0.0, 1.3, 1.0},
                    Aim{"rolling shutter and motion blur", 60, 0.005, 0.001, 0.0, 1.3, 1.0},
                    Aim{"JPEG", 60, 0.01, 0.001, 0.0, 1.3, 1.0},
                    Aim{"bayer_rggb8, red 0.7, blue 0.6", 40, 0.01, kUnbounded, 0.0, kUnbounded,
                        1.0},
                    Aim{"bgr8", 40, 0.01, kUnbounded, 0.0, kUnbounded, 1.0},
                    Aim{"1280x1024", 20, 0.01, 0.001, 0.0, kUnbounded, 1.0}));

/// Part of the images in which a lamp of this radius is found, at one distance.
double foundOf(const DetectorConfig& detector, double radius_m, double distance_m) {
  constexpr int kImages = 10;
  RenderedSeries series = test::renderedSeries("point");
  series.detector = detector;
  std::vector<test::Observation> observations =
      test::observationsAt(distance_m, kImages, 1.0, kSeed);
  for (test::Observation& observation : observations) observation.radius_m = radius_m;
  return static_cast<double>(test::errorsOf(series, observations).found) / kImages;
}

// A lamp that is large beside the aperture looks like a lamp or a window of the room, unless
// its size is known.
TEST(LargeLamp, IsFoundWhereItsSizeIsStated) {
  std::printf("| radius [mm] | distance [m] | found as shipped %% | with its size stated %% |\n");
  for (double radius_m : {0.004, 0.01, 0.02, 0.03}) {
    DetectorConfig stated = test::shippedDetector();
    stated.light.min_radius_m = 0.9 * radius_m;
    stated.light.radius_m = 1.1 * radius_m;
    stated.light.half_height_m = stated.light.radius_m;
    for (double distance_m : {0.4, 0.7, 1.0, 2.0, 4.0}) {
      const double found = foundOf(stated, radius_m, distance_m);
      EXPECT_EQ(found, 1.0) << radius_m << " m, at " << distance_m << " m";
      std::printf("| %.0f | %.1f | %.0f | %.0f |\n", 1e3 * radius_m, distance_m,
                  100.0 * foundOf(test::shippedDetector(), radius_m, distance_m), 100.0 * found);
    }
  }
}

TEST(PointLight, IsReadNearlyAsWellAsThePhotonsAllow) {
  const BearingErrors errors = expectAim({"point", 200, 0.01, 0.001, 0.4, 1.3, 1.0});
  const RenderedSeries point = test::renderedSeries("point");
  ImageRenderer renderer(point.rendered, test::plainWall);
  double bound = 0.0;
  constexpr int kBounds = 10;  // they are slow, and vary little
  for (const test::Observation& observation : test::randomObservations(kBounds, 1.0, kSeed)) {
    bound += azimuthBound(&renderer, point.detector.sensor, observation) / kBounds;
  }
  const double ratio = std::sqrt(errors.sum_square_rad2 / errors.found / bound);
  RecordProperty("rmse_over_bound", std::to_string(ratio));
  EXPECT_LT(ratio, 1.8);
  EXPECT_GT(ratio, 0.8) << "below the Cramer-Rao bound";
}

// At 0.3 m the LEDs of an unequal ring stand apart: some images only show one of them.
TEST(RingOfLeds, NearbyALoneLedIsNotTakenForTheWhole) {
  constexpr int kImages = 40;
  const RenderedSeries ring = test::renderedSeries("ring, 30 % unequal");
  const BearingErrors errors =
      test::errorsOf(ring, test::observationsAt(0.3, kImages, ring.brightness, kSeed));
  EXPECT_GT(errors.found, kImages / 2);
  EXPECT_GT(errors.rmse_deg(), 0.5) << "no image shows a lone LED: nothing is tested";
  EXPECT_LT(errors.nees(), 1.3);
}

// 1 rad/s over the 240 rows to the image's middle, 30 us each, is 0.41 deg.
TEST(RollingShutter, IsSeenInTheBearingWhenTheDetectorIsNotTold) {
  const BearingErrors errors =
      test::errorsOf(test::renderedSeries("rolling shutter, not told"), 20, kSeed);
  EXPECT_LT(errors.bias_deg(), -0.2);
}

/// The variance's constants for clipping and the outline were chosen at 5.7 times the light: they
/// hold at other exposures, on observations that were never looked at.
class OtherExposures : public testing::TestWithParam<double> {};

TEST_P(OtherExposures, TheVarianceHoldsOnUnseenObservations) {
  constexpr unsigned kUnseenSeed = 7301;
  constexpr int kImages = 40;
  RenderedSeries point = test::renderedSeries("point");
  point.brightness = GetParam();
  const BearingErrors errors = test::errorsOf(point, kImages, kUnseenSeed);
  EXPECT_EQ(errors.found, kImages);
  EXPECT_LT(errors.rmse_deg(), 0.02);
  EXPECT_LT(errors.nees(), 1.3);
}

INSTANTIATE_TEST_SUITE_P(TimesTheLight, OtherExposures, testing::Values(0.5, 2.5, 10.0));

}  // namespace
}  // namespace bearing_calibration::core
