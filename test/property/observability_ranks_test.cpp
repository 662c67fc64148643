#include "tools/paper/observability_ranks.h"

#include <gtest/gtest.h>

namespace bearing_calibration::core {
namespace {

// What counts and what is neglected lie far apart: the rank is not a matter of the threshold.
TEST(ObservabilityRanks, AreThoseOfTheModel) {
  constexpr double kCounts = 1e-4;
  constexpr double kRounding = 1e-13;
  for (const ObservabilityCase& observed : observabilityCases()) {
    const ObservabilityRank found = rankOf(observed);
    EXPECT_EQ(found.rank, observed.expected_rank) << observed.motion;
    EXPECT_GT(found.least_counted, kCounts) << observed.motion;
    EXPECT_LT(found.most_neglected, kRounding) << observed.motion;
  }
}

TEST(ObservabilityRanks, AWrongRankIsSaid) {
  ObservabilityCase observed = observabilityCases().front();
  EXPECT_EQ(observabilityTable({observed}).find("not as expected"), std::string::npos);
  ++observed.expected_rank;
  EXPECT_NE(observabilityTable({observed}).find("not as expected"), std::string::npos);
}

}  // namespace
}  // namespace bearing_calibration::core
