// Circles through points: where they are, and how sure a fit says that it is, by closed forms.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/mirror_rim.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

TEST(CircleThrough, PointsOfACircleAndOfALine) {
  const auto circle = circleThrough({4.0, 2.0}, {1.0, 5.0}, {-2.0, 2.0});
  ASSERT_TRUE(circle);
  EXPECT_NEAR((circle->centre_px - Vector2d(1.0, 2.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(circle->radius_px, 3.0, 1e-12);
  EXPECT_FALSE(circleThrough({0.0, 0.0}, {1.0, 1.0}, {3.0, 3.0}));
  EXPECT_FALSE(fitCircle({{0.0, 0.0}, {1.0, 0.0}, {2.0, 0.0}, {3.0, 0.0}}, {{0.0, 0.0}, 1.0}));
}

// Of n points all around with an error sigma across the circle: variances 2 sigma^2 / n of each
// coordinate of the centre, sigma^2 / n of the radius, over Tukey's efficiency of 95 %.
TEST(CircleFit, ItsVariancesAreThoseOfPointsAllAround) {
  constexpr int kSets = 5000;
  constexpr int kPoints = 720;
  constexpr double kSigma_px = 0.3;
  constexpr double kEfficiency = 0.95;
  const Circle truth{{320.0, 240.0}, 180.0};
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, kSigma_px);
  Eigen::Vector3d variances_px2 = Eigen::Vector3d::Zero();
  for (int set = 0; set < kSets; ++set) {
    std::vector<Vector2d> points_px;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2.0 * kPi * i / kPoints;
      points_px.push_back(truth.centre_px + (truth.radius_px + noise(random)) *
                                                Vector2d(std::cos(angle), std::sin(angle)));
    }
    const auto fit = fitCircle(points_px, truth);
    ASSERT_TRUE(fit);
    variances_px2 += fit->covariance_px2.diagonal() / kSets;
    for (int parameter = 0; parameter < 3; ++parameter) {
      EXPECT_DOUBLE_EQ(std::pow(fit->stddev(parameter), 2),
                       fit->covariance_px2(parameter, parameter));
    }
  }
  const double of_radius_px2 = kSigma_px * kSigma_px / (kPoints * kEfficiency);
  const Eigen::Vector3d expected_px2(2.0 * of_radius_px2, 2.0 * of_radius_px2, of_radius_px2);
  // Of 36 groups, whose shares of a coordinate go with cos^2: 24 degrees of freedom in effect, less
  // what is fitted, in each set's variance; four standard deviations of their mean.
  constexpr double kFree = 24.0 * 33.0 / 36.0;
  const double most = 4.0 * std::sqrt(2.0 / kFree / kSets);
  for (int parameter = 0; parameter < 3; ++parameter) {
    EXPECT_NEAR(variances_px2(parameter) / expected_px2(parameter), 1.0, most) << parameter;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
