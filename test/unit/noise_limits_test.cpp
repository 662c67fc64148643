#include <gtest/gtest.h>

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

}  // namespace
}  // namespace bearing_calibration::core
