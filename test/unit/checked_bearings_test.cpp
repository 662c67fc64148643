#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/input/bearing_input.h"

namespace bearing_calibration::core {
namespace {

// What the sensor says, what is added in the configuration, and what a mirror's geometry leaves out
// have nothing to do with each other: their variances add up.
TEST(CheckedBearings, HaveTheVariancesOfAllThatIsIndependent) {
  constexpr double kStated_rad = 0.012;
  BearingInputConfig config;
  config.extra_stddev_rad = 0.004;
  config.max_stddev_rad = 1.0;
  BearingSet set;
  set.candidates.resize(1);
  set.candidates[0].azimuth_variance_rad2 = kStated_rad * kStated_rad;
  set.geometry.harmonic_stddev_rad = 0.1;
  const CheckedBearings checked = checkBearings(set, config);
  ASSERT_EQ(checked.bearings.candidates.size(), 1U);
  EXPECT_NEAR(std::sqrt(checked.bearings.candidates[0].azimuth_variance_rad2),
              std::hypot(kStated_rad, config.extra_stddev_rad, set.geometry.unmodelledStddev()),
              1e-12);
}

// Nobody's sensor is better than the least standard deviation, in whatever direction.
TEST(CheckedBearings, AreNoBetterThanTheLeastStandardDeviation) {
  BearingInputConfig config;
  config.min_stddev_rad = 0.02;
  config.max_stddev_rad = 1.0;
  BearingSet set;
  set.candidates.resize(1);
  set.candidates[0].azimuth_variance_rad2 = 1e-6;
  set.candidates[0].elevation_variance_rad2 = 1e-6;
  const CheckedBearings checked = checkBearings(set, config);
  ASSERT_EQ(checked.bearings.candidates.size(), 1U);
  EXPECT_NEAR(checked.bearings.candidates[0].azimuth_variance_rad2, 4e-4, 1e-15);
  EXPECT_NEAR(checked.bearings.candidates[0].elevation_variance_rad2, 4e-4, 1e-15);
  EXPECT_EQ(checked.remarks.size(), 2U);
}

TEST(CheckedBearings, AreRefusedBeyondTheLargestStandardDeviation) {
  BearingInputConfig config;
  config.max_stddev_rad = 0.5;
  for (const double stddev_rad : {0.49, 0.51, 0.7}) {
    BearingSet set;
    set.candidates.resize(1);
    set.candidates[0].azimuth_variance_rad2 = stddev_rad * stddev_rad;
    const CheckedBearings checked = checkBearings(set, config);
    ASSERT_EQ(checked.remarks.size(), stddev_rad > 0.5 ? 1U : 0U) << stddev_rad;
    for (const InputOutcome& remark : checked.remarks) {
      EXPECT_EQ(remark.status, InputStatus::kVarianceAbsurd);
    }
  }
}

// Promise refused: an elevation in degrees; the azimuth beside it is used
TEST(CheckedBearings, HaveNoElevationThatIsNone) {
  BearingInputConfig config;
  config.max_stddev_rad = 1.0;
  for (const double elevation_rad : {0.3, -1.6, 12.0, -89.0}) {
    BearingSet set;
    set.candidates.resize(1);
    set.candidates[0].azimuth_rad = 0.7;
    set.candidates[0].azimuth_variance_rad2 = 1e-4;
    set.candidates[0].elevation_rad = elevation_rad;
    set.candidates[0].elevation_variance_rad2 = 1e-4;
    const CheckedBearings checked = checkBearings(set, config);
    ASSERT_EQ(checked.bearings.candidates.size(), 1U);
    EXPECT_EQ(checked.bearings.candidates[0].azimuth_rad, 0.7);
    const bool is_one = std::abs(elevation_rad) < 2.0;
    EXPECT_EQ(elevationOf(checked.bearings.candidates[0]).has_value(), is_one) << elevation_rad;
    ASSERT_EQ(checked.remarks.size(), is_one ? 0U : 1U);
    if (is_one) continue;
    EXPECT_EQ(checked.remarks[0].status, InputStatus::kElevationLeftOut);
    EXPECT_EQ(checked.remarks[0].value, elevation_rad);
    EXPECT_TRUE(checked.remarks[0].isWorthAWord());
    EXPECT_FALSE(checked.remarks[0].isBadInput());
  }
}

}  // namespace
}  // namespace bearing_calibration::core
