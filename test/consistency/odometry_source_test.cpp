// The calibration by a driver's odometry, beside the one by the ticks that the odometry is made of:
// the figures of robots.md.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/chi_square.h"
#include "support/simulated_calibration.h"
#include "tools/study/default_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

constexpr int kRuns = 20;

/// Late stamps, and wheels and a separation as far off as the calibration is told that they may be.
SimulatedCase imperfectCase(std::uint64_t seed) {
  using Kind = TrajectoryConfig::Kind;
  constexpr Kind kMotions[] = {Kind::kDance, Kind::kTurns, Kind::kSinusoid, Kind::kRandom};
  RandomCaseRange range;
  range.max_light_distance_m = 3.0;
  SimulatedCase simulated = randomCase(seed, kMotions[seed % 4], range);
  simulated.looked_for = usualErrors();
  const ErrorVector& priors = simulated.looked_for.stddev;
  ImperfectRobot how;
  how.max_random_offset_s = 0.1;
  how.random_ratio_stddev = std::sqrt(2.0) * priors(placeOf<WheelScales>());
  how.random_scale_stddev = std::sqrt(0.5) * priors(placeOf<WheelScales>());
  how.random_separation_stddev = priors(placeOf<WheelSeparation>());
  makeImperfect(simulated, how, seed);
  return simulated;
}

/// A driver that knows nothing of arcs: it goes by the heading at the middle of each step, or at
/// its beginning.
class Driver {
 public:
  Driver(const DriveGeometry& drive, const WheelCounts& first, bool by_middle)
      : drive_(drive), last_(first), by_middle_(by_middle) {}

  OdometryPose add(const WheelCounts& ticks) {
    const double left_m =
        static_cast<double>(ticks.left_ticks - last_.left_ticks) * drive_.leftMetersPerTick();
    const double right_m =
        static_cast<double>(ticks.right_ticks - last_.right_ticks) * drive_.rightMetersPerTick();
    last_ = ticks;
    const double turn = (right_m - left_m) / drive_.wheel_separation_m;
    const double heading = heading_ + (by_middle_ ? 0.5 * turn : 0.0);
    x_m_ += 0.5 * (left_m + right_m) * std::cos(heading);
    y_m_ += 0.5 * (left_m + right_m) * std::sin(heading);
    heading_ += turn;
    OdometryPose pose;
    pose.stamp = ticks.stamp;
    pose.start_from_base = {{x_m_, y_m_}, std::remainder(heading_, 2.0 * kPi)};
    return pose;
  }

 private:
  DriveGeometry drive_;
  WheelCounts last_;
  bool by_middle_;
  double x_m_ = 0.0;
  double y_m_ = 0.0;
  double heading_ = 0.0;
};

/// `addWheels` gives a reading of the wheels to the calibrator.
template <class AddWheels>
CalibrationResult calibrate(const SimulatedCase& simulated, const SimulatedRecord& record,
                            AddWheels addWheels) {
  const EncoderConfig& encoders = simulated.robot.encoders;
  CalibratorConfig config = defaultCalibration(encoders.drive, encoders.noise);
  config.initializer.batch.errors = simulated.looked_for;
  config.initializer.noise = usualNoise();
  Calibrator calibrator(config);
  auto bearings = record.bearings.begin();
  for (const WheelCounts& ticks : record.ticks) {
    for (; bearings != record.bearings.end() && bearings->stamp <= ticks.stamp; ++bearings) {
      calibrator.addBearings(*bearings, bearings->stamp);
    }
    addWheels(&calibrator, ticks);
  }
  return calibrator.result();
}

struct TwoResults {
  CalibrationResult by_ticks;
  CalibrationResult by_odometry;
  Pose2 truth;
};

TwoResults calibrateTwice(std::uint64_t seed) {
  const SimulatedCase simulated = imperfectCase(seed);
  const ObservationRun run = simulate(simulated);
  // both ways with each of the four motions
  Driver driver(simulated.robot.encoders.drive, run.record.ticks.front(), seed / 4 % 2 == 0);
  return {calibrate(simulated, run.record,
                    [](Calibrator* calibrator, const WheelCounts& ticks) {
                      calibrator->addTicks(ticks, ticks.stamp);
                    }),
          calibrate(simulated, run.record,
                    [&](Calibrator* calibrator, const WheelCounts& ticks) {
                      calibrator->addOdometry(driver.add(ticks), ticks.stamp);
                    }),
          simulated.robot.base_from_sensor};
}

TEST(OdometrySource, FindsTheMountAsTicksDo) {
  std::vector<TwoResults> runs;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) runs.push_back(calibrateTwice(seed));
  double sum = 0.0, worst_chi_square = 0.0, worst_ratio = 0.0, sum_by_ticks = 0.0;
  for (const TwoResults& run : runs) {
    ASSERT_TRUE(run.by_odometry.base_from_sensor.has_value()) << run.by_odometry.advice;
    ASSERT_TRUE(run.by_ticks.base_from_sensor.has_value()) << run.by_ticks.advice;
    EXPECT_EQ(run.by_odometry.tick_inputs.remarks(), 0U);
    const MountEstimate& found = *run.by_odometry.base_from_sensor;
    const double chi_square = testing::mountChiSquare(found, run.truth);
    EXPECT_LT(chi_square, 25.0);
    const Eigen::Array3d variances = found.covariance.diagonal();
    const Eigen::Array3d by_ticks = run.by_ticks.base_from_sensor->covariance.diagonal();
    const double ratio = (variances / by_ticks).sqrt().maxCoeff();
    EXPECT_LT(ratio, 1.3);
    std::printf("off by %5.1f mm %5.2f deg, chi-square %5.2f, %.3f times the ticks' sigma, %s\n",
                1e3 * (found.mean.head<2>() - run.truth.position_m).norm(),
                degreesFromRadians(wrapAngle(found.mean.z() - run.truth.yaw_rad)), chi_square,
                ratio, nameOf(run.by_odometry.state));
    sum += chi_square;
    sum_by_ticks += testing::mountChiSquare(*run.by_ticks.base_from_sensor, run.truth);
    worst_chi_square = std::max(worst_chi_square, chi_square);
    worst_ratio = std::max(worst_ratio, ratio);
  }
  constexpr double kDegrees = 3.0 * kRuns;
  const double least = chiSquareQuantile(0.005, kDegrees);
  const double most = chiSquareQuantile(0.995, kDegrees);
  std::printf(
      "%d runs: NEES/3 %.2f (ticks %.2f; 99 %% of honest ones %.2f to %.2f), largest chi-square "
      "%.1f, largest ratio of sigmas %.3f\n",
      kRuns, sum / kDegrees, sum_by_ticks / kDegrees, least / kDegrees, most / kDegrees,
      worst_chi_square, worst_ratio);
  EXPECT_GT(sum, least);
  EXPECT_LT(sum, most);
}

}  // namespace
}  // namespace bearing_calibration::core
