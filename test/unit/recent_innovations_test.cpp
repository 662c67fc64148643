#include <gtest/gtest.h>

#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {
namespace {

TEST(RecentInnovations, ThereAreNoneAtFirst) {
  const Consistency consistency = RecentInnovations().consistency();
  EXPECT_EQ(consistency.nis_mean, 0.0);
  EXPECT_EQ(consistency.fused + consistency.not_fused, 0);
}

TEST(RecentInnovations, TheirMeanIsOverThoseThatWereFused) {
  RecentInnovations recent;
  recent.noteFused(1.0);
  recent.noteNotFused();
  recent.noteFused(4.0);
  recent.noteFused(2.5);
  recent.noteNotFused();
  const Consistency consistency = recent.consistency();
  EXPECT_EQ(consistency.fused, 3);
  EXPECT_EQ(consistency.not_fused, 2);
  EXPECT_EQ(consistency.nis, 2.5);
  EXPECT_NEAR(consistency.nis_mean, 2.5, 1e-12);
}

TEST(RecentInnovations, OldOnesAreForgotten) {
  RecentInnovations recent;
  recent.noteNotFused();
  recent.noteFused(1e6);
  for (int i = 0; i < RecentInnovations::kWindow; ++i) recent.noteFused(1.0);
  EXPECT_EQ(recent.consistency().fused, RecentInnovations::kWindow);
  EXPECT_EQ(recent.consistency().not_fused, 0);
  EXPECT_NEAR(recent.consistency().nis_mean, 1.0, 1e-12);
}

}  // namespace
}  // namespace bearing_calibration::core
