#include "bearing_calibration/init/closed_form.h"

#include <gtest/gtest.h>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/init/start_candidates.h"
#include "support/yaw_scan.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using Kind = TrajectoryConfig::Kind;

const Kind kGeneralMotions[] = {Kind::kDance, Kind::kTurns, Kind::kSinusoid, Kind::kRandom};

/// Observations of a random case along its odometry, with exact bearings when `exact`.
struct Record {
  std::vector<PosedObservation> observations;
  Vector5 truth_at_first;
};

Record makeRecord(std::uint64_t seed, Kind kind, double duration_s, bool exact) {
  SimulatedCase simulated = randomCase(seed, kind, RandomCaseRange());
  simulated.duration_s = duration_s;
  if (exact) {
    simulated.robot.sensor.stddev_rad = 0.0;
    simulated.robot.encoders.noise = {0.0, 0.0};
    simulated.robot.encoders.drive.ticks_per_revolution = 1e9;  // 0.3 nm: no quantisation
    simulated.robot.encoders.drive.counter_bits = 64;
  }
  const ObservationRun run = simulate(simulated);
  Record record{poseObservations(run.observations), run.truth.front()};
  if (!exact) return record;
  // exact to rounding: what the truth shows from the poses of the record itself
  for (PosedObservation& observation : record.observations) {
    observation.azimuth_rad += residualAt(observation, record.truth_at_first) * -1.0;
  }
  return record;
}

double mountError(const Vector5& a, const Vector5& b) {
  Vector5 difference = a - b;
  difference(4) = wrapAngle(difference(4));
  return difference.cwiseAbs().maxCoeff();
}

// Without noise the closed form is exact, whatever the mount, the light and the heading.
TEST(ClosedForm, IsExactWithoutNoise) {
  constexpr int kCases = 400;
  for (int i = 0; i < kCases; ++i) {
    const Record record =
        makeRecord(static_cast<std::uint64_t>(i + 1), kGeneralMotions[i % 4], 20.0, true);
    ClosedForm form;
    for (const PosedObservation& observation : record.observations) form.add(observation, 1.0);
    const auto solved = form.solve();
    ASSERT_TRUE(solved) << "case " << i;
    EXPECT_LT(mountError(withLightInFront(record.observations, *solved), record.truth_at_first),
              1e-6)
        << "case " << i << "\nfound " << solved->transpose() << "\ntruth "
        << record.truth_at_first.transpose();
  }
}

// The twin of an answer, turned by half a turn, has the same lines and the light behind.
TEST(ClosedForm, ChoosesTheTwinWithTheLightInFront) {
  const Record record = makeRecord(7, Kind::kDance, 20.0, true);
  Vector5 twin = record.truth_at_first;
  twin(CartesianIndex::kSensorYaw) += kPi;
  EXPECT_LT(mountError(withLightInFront(record.observations, twin), record.truth_at_first), 1e-12);
  EXPECT_LT(mountError(withLightInFront(record.observations, record.truth_at_first),
                       record.truth_at_first),
            1e-12);
}

// Exact bearings cost nothing at the truth, where the steps are Newton's: what remains is less than
// the last gain, also after a start from where the first steps had to be short.
TEST(FixedPathFit, StepsGrowAgainOnceTheyHaveBeenShort) {
  constexpr double kSettledGain = 1e-3;
  Record record = makeRecord(7, Kind::kDance, 20.0, false);
  for (PosedObservation& observation : record.observations) {
    observation.azimuth_rad -= residualAt(observation, record.truth_at_first);
  }
  for (const double times_as_far : {0.1, 0.3, 3.0, 10.0}) {
    Vector5 start = record.truth_at_first;
    start.head<2>() *= times_as_far;
    const FixedPathFit fit =
        fitOnFixedPath(record.observations, start, {record.observations.size() / 2});
    EXPECT_LT(fit.cost, kSettledGain) << times_as_far;
  }
}

// Consensus and fit reach the global minimum that a scan of all yaws finds.
TEST(FindConsensus, FindsTheMinimumOfTheScan) {
  constexpr int kCases = 60;
  constexpr int kYaws = 180;
  for (int i = 0; i < kCases; ++i) {
    const Record record =
        makeRecord(static_cast<std::uint64_t>(i + 1), kGeneralMotions[i % 4], 15.0, false);
    const FixedPathFit found = findConsensus(record.observations, {0, record.observations.size()},
                                             static_cast<std::uint32_t>(i));
    const Vector5 scanned = testing::scanYaw(record.observations, kYaws);
    // Without outliers Huber's cost is nearly that of least squares; the scan is not refined, so
    // the fit must be below it but for what Huber's weights shift.
    constexpr double kHuberShift = 1.02;
    EXPECT_LT(testing::angularCost(record.observations, found.state_at_first),
              kHuberShift * testing::angularCost(record.observations, scanned))
        << "case " << i << "\nfound   " << found.state_at_first.transpose() << "\nscanned "
        << scanned.transpose() << "\ntruth   " << record.truth_at_first.transpose();
  }
}

// 30 % of uniform bearings: with the true mount in reach, most of them are found out. (A mount that
// the record itself hardly determines is not near the truth without outliers either.)
TEST(FindConsensus, OutliersMakeNoDifference) {
  constexpr int kCases = 100;
  constexpr double kSameWithin_m = 0.1;
  int same = 0;
  for (int i = 0; i < kCases; ++i) {
    SimulatedCase simulated =
        randomCase(static_cast<std::uint64_t>(i + 1), kGeneralMotions[i % 4], {1.0, 0.3, 3.0});
    simulated.duration_s = 20.0;
    const auto consensusWith = [&simulated](double outliers) {
      simulated.robot.sensor.outlier_probability = outliers;
      const std::vector<PosedObservation> observations =
          poseObservations(thinned(simulate(simulated).observations, 150));
      return findConsensus(observations, {0, observations.size()}, 1).state_at_first;
    };
    same += isSameMount(consensusWith(0.0), consensusWith(0.3), kSameWithin_m) ? 1 : 0;
  }
  EXPECT_GE(same, 90);  // the smoother and the other windows have the rest
}

TEST(StartWindows, CoverTheRecordAtEveryScale) {
  const std::vector<Stretch> windows = startWindows(100);
  ASSERT_EQ(windows.size(), 7U);
  EXPECT_EQ(windows[0].size(), 100U);
  EXPECT_EQ(windows[1].end, windows[2].begin);
  EXPECT_EQ(windows[3].size() + windows[4].size() + windows[5].size() + windows[6].size(), 100U);
  EXPECT_TRUE(startWindows(10).empty());
}

}  // namespace
}  // namespace bearing_calibration::core
