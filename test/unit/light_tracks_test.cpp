#include "bearing_calibration/vision/light_tracks.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

constexpr double kFrame_s = 0.1;

SearchConfig fastTurns() {
  SearchConfig config;
  config.max_turn_rate_radps = 2.0;
  config.max_radius_rate_pxps = 100.0;
  return config;
}

Bearing candidateAt(double azimuth_rad, double radius_px, double probability) {
  Bearing bearing;
  bearing.azimuth_rad = wrapAngle(azimuth_rad);
  bearing.image_radius_px = radius_px;
  bearing.probability = probability;
  return bearing;
}

/// One image after the other, a tenth of a second apart.
class Images {
 public:
  /// @return the track's probability of each candidate
  std::vector<double> next(const std::vector<Bearing>& candidates, double part_searched = 1.0,
                           const std::optional<double>& expected_rad = std::nullopt,
                           std::int32_t expected_light = 3) {
    BearingSet set{stampFromSeconds(100.0 + kFrame_s * image_++), candidates};
    std::optional<BearingPrediction> expected;
    if (expected_rad) {
      expected = BearingPrediction{set.stamp, wrapAngle(*expected_rad), 1e-4, expected_light};
    }
    tracks_.follow(part_searched, expected, &set);
    std::vector<double> probabilities;
    for (const Bearing& bearing : set.candidates) {
      probabilities.push_back(bearing.track_probability);
    }
    return probabilities;
  }
  void rewind() { image_ = 0; }

 private:
  LightTracks tracks_{fastTurns()};
  int image_ = 0;
};

double logOdds(double probability) { return std::log(probability / (1.0 - probability)); }

/// Log odds after so many images of one probability.
double logOddsAfter(int images, double probability) {
  Images seen;
  double last = 0.0;
  for (int i = 0; i < images; ++i) {
    last = seen.next({candidateAt(0.0, 150.0, probability)}).at(0);
  }
  return logOdds(last);
}

/// By how many independent ones n numbers of correlation rho weigh: the sum of the elements of the
/// inverse of their correlation matrix.
double independentOnes(int n, double rho) {
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Constant(n, n, rho);
  correlation.diagonal().setOnes();
  return correlation.inverse().sum();
}

TEST(LightTracks, OneImageSaysWhatItSays) {
  for (double probability : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(logOddsAfter(1, probability), logOdds(probability), 1e-9);
  }
}

// What an image says beyond what is even grows with the number of images as the evidence of equally
// correlated normal numbers does.
TEST(LightTracks, ImagesCountAsOftenAsTheyAreIndependent) {
  const double weight = (logOddsAfter(2, 0.9) - logOddsAfter(2, 0.5)) / logOdds(0.9);
  const double even = logOddsAfter(2, 0.5) / (1.0 - weight);
  const double rho = 2.0 / weight - 1.0;
  ASSERT_GT(rho, 0.1);
  ASSERT_LT(rho, 0.9);
  for (int images : {3, 10, 25}) {
    EXPECT_NEAR(logOddsAfter(images, 0.8),
                even + independentOnes(images, rho) * (logOdds(0.8) - even), 1e-6)
        << images;
  }
}

TEST(LightTracks, WhatFlickersIsNoLight) {
  Images images;
  double seen = 0.0;
  for (int i = 0; i < 10; ++i) {
    seen = images.next({candidateAt(0.3, 120.0, 0.8)}).at(0);
    images.next({});
  }
  EXPECT_LT(seen, 0.5);
}

TEST(LightTracks, WhereNothingWasLookedForNothingIsMissed) {
  Images images;
  Images without_gaps;
  double seen = 0.0;
  double expected = 0.0;
  for (int i = 0; i < 5; ++i) {
    seen = images.next({candidateAt(0.3, 120.0, 0.8)}).at(0);
    expected = without_gaps.next({candidateAt(0.3, 120.0, 0.8)}).at(0);
    images.next({}, 0.05);
  }
  EXPECT_DOUBLE_EQ(seen, expected);
}

// Where it was expected was computed from earlier answers: they would confirm themselves.
TEST(LightTracks, WhatIsExpectedIsNoLikelierForIt) {
  const DetectorConfig config = test::defaultDetector();
  LightDetector detector(config);
  test::SpotDrawing large =
      test::spotOfLight(config, {1.0, test::kDefaultLightHeight_m}, 0.7, 160.0);
  large.major_diameter_px *= 2.1;
  large.minor_diameter_px *= 2.1;
  cv::Mat image = test::flatImage(config.sensor.width_px, config.sensor.height_px, 20.0);
  addSpot(&image, large);
  image.convertTo(image, CV_8U);
  const auto trackOf = [&](const std::optional<SearchRegion>& region) {
    const DetectionResult& seen = detector.detect(image, region);
    EXPECT_EQ(seen.in_region, region.has_value());
    Images images;
    return images.next({seen.lights.at(0).bearing}, seen.part_searched).at(0);
  };
  const double by_whole = trackOf(std::nullopt);
  EXPECT_GT(by_whole, 0.5);
  EXPECT_LT(by_whole, 0.99);
  EXPECT_NEAR(trackOf(SearchRegion{std::nullopt, {0.75, 0.2}}), by_whole, 1e-9);
}

// At 1.5 rad/s both turn by more between two images than they are apart.
TEST(LightTracks, KeepsTwoApartThatTurnTogether) {
  Images images;
  std::vector<double> seen;
  for (int i = 0; i < 5; ++i) {
    const double turn_rad = 1.5 * kFrame_s * i;
    seen = images.next(
        {candidateAt(3.0 + turn_rad, 150.0, 0.9), candidateAt(3.1 + turn_rad, 175.0, 0.2)});
  }
  EXPECT_GT(seen.at(0), 0.92);
  EXPECT_LT(seen.at(1), 0.2);
}

TEST(LightTracks, WhatTurnsWithTheRobotIsOnIt) {
  Images images;
  std::vector<double> seen;
  for (int i = 0; i < 10; ++i) {
    const double turn_rad = -1.0 * kFrame_s * i;
    seen = images.next({candidateAt(1.0 + turn_rad, 150.0, 0.9), candidateAt(-2.0, 110.0, 0.9)},
                       1.0, 1.0 + turn_rad);
  }
  EXPECT_GT(seen.at(0), 0.9);
  EXPECT_LT(seen.at(1), 0.5);
}

TEST(LightTracks, WhatStandsWhileTheRobotStandsMayBeALight) {
  Images images;
  std::vector<double> seen;
  for (int i = 0; i < 10; ++i) {
    seen = images.next({candidateAt(-2.0, 110.0, 0.9)}, 1.0, 1.0);
  }
  EXPECT_GT(seen.at(0), 0.9);
}

TEST(LightTracks, PredictionsOfTwoLightsAreNoTurn) {
  Images images;
  std::vector<double> seen;
  for (int i = 0; i < 10; ++i) {
    const bool first = i % 2 == 0;
    seen = images.next({candidateAt(-2.0, 110.0, 0.9)}, 1.0, first ? 1.0 : 2.5, first ? 3 : 4);
  }
  EXPECT_GT(seen.at(0), 0.9);
}

TEST(LightTracks, AnEarlierStampBeginsAnew) {
  Images images;
  for (int i = 0; i < 10; ++i) images.next({candidateAt(0.0, 150.0, 0.2)});
  images.rewind();
  EXPECT_NEAR(images.next({candidateAt(0.0, 150.0, 0.8)}).at(0), 0.8, 1e-9);
}

TEST(LightTracks, FollowsWithoutAnImageRadius) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Images images;
  for (int i = 0; i < 5; ++i) images.next({candidateAt(0.0, kNaN, 0.2)});
  EXPECT_LT(images.next({candidateAt(0.0, kNaN, 0.8)}).at(0), 0.8);
}

}  // namespace
}  // namespace bearing_calibration::core
