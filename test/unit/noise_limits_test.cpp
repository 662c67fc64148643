#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/noise/noise_levels.h"

namespace bearing_calibration::core {
namespace {

TEST(NoiseLevels, AtMostALimitAreTheLowerOnesOfEach) {
  const NoiseLevels low{{1.1, 0.1}, {2.0, 0.2}, {0.001, 0.3}};
  const NoiseLevels high{{1.5, 0.4}, {3.0, 0.5}, {0.004, 0.6}};
  for (const NoiseLevels& levels : {atMost(low, high), atMost(high, low)}) {
    EXPECT_EQ(levels.bearing.value, low.bearing.value);
    EXPECT_EQ(levels.wheel.value, low.wheel.value);
    EXPECT_EQ(levels.light_size.stddev_m, low.light_size.stddev_m);
  }
  const NoiseLevels mixed = atMost({low.bearing, high.wheel}, {high.bearing, low.wheel});
  EXPECT_EQ(mixed.bearing.value, low.bearing.value);
  EXPECT_EQ(mixed.wheel.value, low.wheel.value);
}

// n bearings of which neighbours are correlated by 0.5 are worth (1 - 0.5) / (1 + 0.5) n.
TEST(NoiseLevels, OfCorrelatedBearingsAreWidenedByTheRootOfThoseThatAreLost) {
  const NoiseLevels levels{{1.1, 0.1}, {2.0, 0.2}, {0.001, 0.3}};
  const NoiseLevels widened = levels.widenedFor(0.5);
  EXPECT_NEAR(widened.bearing.value, std::sqrt(3.0) * 1.1, 1e-12);
  EXPECT_NEAR(widened.light_size.stddev_m, std::sqrt(3.0) * 0.001, 1e-12);
  EXPECT_EQ(widened.wheel.value, 2.0);
}

// Wheels that are better than stated say nothing of what a break in their readings has hidden.
TEST(NoiseLevels, WhatNobodyHasSeenIsNotKnownAnyBetter) {
  NoiseLevels quiet;
  quiet.wheel.value = 0.01;
  NoiseLevels loud;
  loud.wheel.value = 100.0;
  const OdometryIncrement seen = append({}, {0.1, 0.2}, 0.25, {1e-6, 0.0});
  const OdometryIncrement unseen = append(seen, {0.0, 0.0}, 0.25, {1e-6, 0.0}, 0.3);
  const OdometryIncrement both = append(unseen, seen);
  for (const OdometryIncrement& motion : {unseen, both}) {
    EXPECT_TRUE(motion.has_unseen);
    EXPECT_EQ(withNoise(motion, quiet).covariance, motion.covariance);
    EXPECT_EQ(withNoise(motion, loud).covariance, 100.0 * motion.covariance);
  }
  EXPECT_FALSE(seen.has_unseen);
  EXPECT_EQ(withNoise(seen, quiet).covariance, 0.01 * seen.covariance);
}

}  // namespace
}  // namespace bearing_calibration::core
