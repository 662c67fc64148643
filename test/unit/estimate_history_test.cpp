#include "tools/owner/estimate_history.h"

#include <gtest/gtest.h>

namespace bearing_calibration::core {
namespace {

CalibrationResult resultAfter(int seconds) {
  CalibrationResult result;
  result.stamp = stampFromSeconds(seconds);
  result.distance_travelled_m = seconds;
  result.base_from_sensor = MountEstimate{};
  return result;
}

// A drive may have any length.
TEST(EstimateHistory, HasABoundAndEndsWithTheResultHoweverLongTheDriveWas) {
  constexpr int kMost = static_cast<int>(EstimateHistory::kMostRows);
  for (const int rows : {1, kMost - 2, kMost - 1, kMost, kMost + 1, 3 * kMost}) {
    EstimateHistory history;
    for (int i = 1; i <= rows; ++i) history.add(resultAfter(i));
    const std::vector<EstimateRow> taken = history.take(resultAfter(rows + 1));
    EXPECT_LE(taken.size(), EstimateHistory::kMostRows);
    EXPECT_EQ(taken.front().stamp, stampFromSeconds(1)) << rows;
    EXPECT_EQ(taken.back().stamp, stampFromSeconds(rows + 1)) << rows;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
