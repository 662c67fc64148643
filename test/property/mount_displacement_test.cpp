#include "bearing_calibration/solve/mount_displacement.h"

#include <gtest/gtest.h>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/rival_mount.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

ObservationRun dance(std::uint64_t seed, double duration_s, const Pose2& mount) {
  SimulatedCase simulated = paperCase(seed);
  simulated.robot.base_from_sensor = mount;
  simulated.duration_s = duration_s;
  return simulate(simulated);
}

/// The first half of one record and the second half of the other.
ObservationRun halfAndHalf(ObservationRun first, const ObservationRun& second) {
  for (std::size_t i = first.observations.size() / 2; i < first.observations.size(); ++i) {
    first.observations[i] = second.observations[i];
    first.truth[i] = second.truth[i];
  }
  return first;
}

BatchEstimate fit(const ObservationRun& run, const SlipHypothesis& slips = {}) {
  const std::size_t last = run.observations.size() - 1;
  return BatchEstimator(BatchConfig()).estimate(run.observations, {run.truth[last], last}, slips);
}

MountEstimate fitPart(const ObservationRun& run, std::size_t begin, std::size_t end) {
  const std::vector<Observation> part(run.observations.begin() + static_cast<std::ptrdiff_t>(begin),
                                      run.observations.begin() + static_cast<std::ptrdiff_t>(end));
  const BatchEstimate estimate =
      BatchEstimator(BatchConfig()).estimate(part, {run.truth[end - 1], part.size() - 1});
  return estimate.last.mount();
}

// With the motion between two parts given up, nothing but the mount joins them: its jump is the
// difference of two fits, one of each part, that know nothing of one another.
TEST(MountDisplacement, IsTheDifferenceOfTwoFitsOfTheirOwn) {
  const Pose2 mount = paperCase(1).robot.base_from_sensor;
  Pose2 displaced = mount;
  displaced.position_m.x() += 0.02;
  displaced.yaw_rad += radiansFromDegrees(2.0);
  const ObservationRun run = halfAndHalf(dance(1, 120.0, mount), dance(1, 120.0, displaced));
  const std::size_t middle = run.observations.size() / 2;
  SlipHypothesis parted;
  parted.given_up = {middle};
  const DisplacementTest test = testDisplacement(fit(run, parted).mount_displacements[middle]);
  constexpr std::size_t kReach = 3;  // observations on either side that a slip takes away
  const MountEstimate before = fitPart(run, 0, middle - kReach + 1);
  const MountEstimate after = fitPart(run, middle + kReach - 1, run.observations.size());
  ASSERT_EQ(test.directions, 3);
  // linearised about another point, and 0.3 m and 0.5 rad of the slip are not quite unknown
  constexpr double kNonlinear = 0.1;
  EXPECT_NEAR(test.gain, disagreement(before, after), kNonlinear * test.gain);
  const Eigen::Vector3d stddev = (before.covariance + after.covariance).diagonal().cwiseSqrt();
  const Eigen::Vector3d expected = after.mean - before.mean;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(test.jump(i), expected(i), 0.5 * stddev(i));
}

TEST(MountDisplacement, OfASoundRobotIsAChiSquareOfThreeDegrees) {
  constexpr int kRuns = 60;
  double sum = 0.0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const ObservationRun run =
        dance(static_cast<std::uint64_t>(seed), 40.0, paperCase(1).robot.base_from_sensor);
    const DisplacementTest test =
        testDisplacement(fit(run).mount_displacements[run.observations.size() / 2]);
    ASSERT_EQ(test.directions, 3) << "seed " << seed;
    sum += test.gain;
  }
  const double four_stddev = 4.0 * std::sqrt(2.0 * 3.0 / kRuns);
  EXPECT_NEAR(sum / kRuns, 3.0, four_stddev);
}

TEST(MountDisplacement, IsNotToldWhereTheOtherPartHasNoMotionOfItsOwn) {
  const ObservationRun run = dance(1, 40.0, paperCase(1).robot.base_from_sensor);
  const BatchEstimate estimate = fit(run);
  EXPECT_EQ(testDisplacement(estimate.mount_displacements.front()).directions, 0);
  EXPECT_LT(testDisplacement(estimate.mount_displacements.back()).directions, 3);
}

}  // namespace
}  // namespace bearing_calibration::core
