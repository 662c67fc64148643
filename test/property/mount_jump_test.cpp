#include "bearing_calibration/calibration/mount_jump.h"

#include <gtest/gtest.h>

#include "bearing_calibration/calibration/batch_estimator.h"
#include "bearing_calibration/calibration/mount_agreement.h"
#include "bearing_calibration/common/angle.h"
#include "tools/simulated_case.h"

namespace bearing_calibration {
namespace {

SightRun dance(std::uint64_t seed, double duration_s, const Pose2& mount) {
  SimulatedCase simulated = paperCase(seed);
  simulated.robot.base_from_sensor = mount;
  simulated.duration_s = duration_s;
  return simulate(simulated);
}

/// The first half of one record and the second half of the other.
SightRun halfAndHalf(SightRun first, const SightRun& second) {
  for (std::size_t i = first.sights.size() / 2; i < first.sights.size(); ++i) {
    first.sights[i] = second.sights[i];
    first.truth[i] = second.truth[i];
  }
  return first;
}

BatchEstimate fit(const SightRun& run, const SlipHypothesis& slips = {}) {
  const std::size_t last = run.sights.size() - 1;
  return BatchEstimator(BatchConfig()).estimate(run.sights, {run.truth[last], last}, slips);
}

MountEstimate fitPart(const SightRun& run, std::size_t begin, std::size_t end) {
  const std::vector<Sight> part(run.sights.begin() + static_cast<std::ptrdiff_t>(begin),
                                run.sights.begin() + static_cast<std::ptrdiff_t>(end));
  const BatchEstimate estimate =
      BatchEstimator(BatchConfig()).estimate(part, {run.truth[end - 1], part.size() - 1});
  return mountFromCartesian(estimate.at_last_sight);
}

// With the motion between two parts given up, nothing but the mount joins them: its jump is the
// difference of two fits, one of each part, that know nothing of one another.
TEST(MountJump, IsTheDifferenceOfTwoFitsOfTheirOwn) {
  const Pose2 mount = paperCase(1).robot.base_from_sensor;
  Pose2 knocked = mount;
  knocked.position_m.x() += 0.02;
  knocked.yaw_rad += radiansFromDegrees(2.0);
  const SightRun run = halfAndHalf(dance(1, 120.0, mount), dance(1, 120.0, knocked));
  const std::size_t middle = run.sights.size() / 2;
  SlipHypothesis parted;
  parted.given_up = {middle};
  const JumpTest test = testJump(fit(run, parted).mount_jumps[middle]);
  constexpr std::size_t kReach = 3;  // sights on either side that a slip takes away
  const MountEstimate before = fitPart(run, 0, middle - kReach + 1);
  const MountEstimate after = fitPart(run, middle + kReach - 1, run.sights.size());
  ASSERT_EQ(test.directions, 3);
  // linearised about another point, and 0.3 m and 0.5 rad of the slip are not quite unknown
  constexpr double kNonlinear = 0.1;
  EXPECT_NEAR(test.gain, disagreement(before, after), kNonlinear * test.gain);
  const Eigen::Vector3d stddev = (before.covariance + after.covariance).diagonal().cwiseSqrt();
  const Eigen::Vector3d expected = after.mean - before.mean;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(test.jump(i), expected(i), 0.5 * stddev(i));
}

TEST(MountJump, OfASoundRobotIsAChiSquareOfThreeDegrees) {
  constexpr int kRuns = 60;
  double sum = 0.0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const SightRun run =
        dance(static_cast<std::uint64_t>(seed), 40.0, paperCase(1).robot.base_from_sensor);
    const JumpTest test = testJump(fit(run).mount_jumps[run.sights.size() / 2]);
    ASSERT_EQ(test.directions, 3) << "seed " << seed;
    sum += test.gain;
  }
  const double four_stddev = 4.0 * std::sqrt(2.0 * 3.0 / kRuns);
  EXPECT_NEAR(sum / kRuns, 3.0, four_stddev);
}

TEST(MountJump, IsNotToldWhereTheOtherPartHasNoMotionOfItsOwn) {
  const SightRun run = dance(1, 40.0, paperCase(1).robot.base_from_sensor);
  const BatchEstimate estimate = fit(run);
  EXPECT_EQ(testJump(estimate.mount_jumps.front()).directions, 0);
  EXPECT_LT(testJump(estimate.mount_jumps.back()).directions, 3);
}

}  // namespace
}  // namespace bearing_calibration
