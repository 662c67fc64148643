#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/stamp.h"

namespace bearing_calibration::core {
namespace {

TEST(WrapAngle, KeepsTheDirectionAndTheRange) {
  for (int i = -1000; i <= 1000; ++i) {
    const double angle = 0.0371 * i;
    const double wrapped = wrapAngle(angle);
    EXPECT_LE(std::abs(wrapped), kPi);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
  }
}

TEST(WrapAngle, GivesNaNForWhatHasNoDirection) {
  EXPECT_TRUE(std::isnan(wrapAngle(std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(wrapAngle(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Stamp, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(durationFromSeconds(0.1).count(), 100000000);
  EXPECT_EQ(durationFromSeconds(-0.1).count(), -100000000);
  EXPECT_DOUBLE_EQ(secondsFromDuration(durationFromSeconds(1.5)), 1.5);
}

TEST(Stamp, ZeroIsNoMoment) {
  EXPECT_FALSE(isStamped(Stamp()));
  EXPECT_TRUE(isStamped(stampFromNanoseconds(1)));
}

// With two degrees of freedom the distribution is exponential: P(x < v) = 1 - exp(-v/2).
TEST(ChiSquare, AgreesWithTheClosedFormOfTwoDegrees) {
  for (double value : {0.1, 1.0, 5.0, 20.0}) {
    const double probability = 1.0 - std::exp(-0.5 * value);
    EXPECT_NEAR(chiSquareProbability(value, 2.0), probability, 1e-12);
    EXPECT_NEAR(chiSquareQuantile(probability, 2.0), value, 1e-9);
    EXPECT_NEAR(chiSquareExceededBy(std::exp(-0.5 * value), 2.0), value, 1e-9);
  }
  EXPECT_NEAR(chiSquareExceededBy(1e-30, 2.0), 60.0 * std::log(10.0), 1e-9);
}

}  // namespace
}  // namespace bearing_calibration::core
