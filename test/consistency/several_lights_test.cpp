// A mount calibrated with several lights: as good as the bound, as honest as with one.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/chi_square.h"
#include "support/simulated_calibration.h"
#include "tools/study/lights_case.h"
#include "tools/study/monte_carlo_table.h"

namespace bearing_calibration::core {
namespace {

constexpr double kImages_hz = 10.0;

SimulatedCase danceWith(int lights, std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  addLights(simulated, lights, seed);
  simulated.robot.sensor.identifies_lights = true;
  return simulated;
}

std::vector<Trial> runBatches(int lights, int runs) {
  std::vector<Trial> trials;
  for (int i = 0; i < runs; ++i) {
    trials.push_back(tryBatch(danceWith(lights, static_cast<std::uint64_t>(i + 1)), {100.0}));
  }
  return trials;
}

class SeveralLightsBatch : public ::testing::TestWithParam<int> {};

TEST_P(SeveralLightsBatch, ReachesTheBoundAndSaysHowFarItIsOff) {
  constexpr int kRuns = 40;
  constexpr double kFalseAlarm = 1e-3;
  const std::vector<TableRow> rows = summarise(runBatches(GetParam(), kRuns));
  const TableRow& row = rows.front();
  EXPECT_EQ(row.claimed, kRuns) << format(rows);
  const double degrees = 3.0 * kRuns;
  EXPECT_LT(row.mount_nees, chiSquareQuantile(1.0 - kFalseAlarm, degrees) / degrees);
  EXPECT_GT(row.mount_nees, chiSquareQuantile(kFalseAlarm, degrees) / degrees);
  // RMSE over bound of n runs scatters by 1 / sqrt(2 n)
  EXPECT_LT(row.rmse_per_bound.maxCoeff(), 1.0 + 4.0 / std::sqrt(2.0 * kRuns)) << format(rows);
}

INSTANTIATE_TEST_SUITE_P(Lights, SeveralLightsBatch, ::testing::Values(2, 4));

/// What a calibrator for `most` lights says of a record, and the worst that it ever claimed.
struct Told {
  CalibrationResult result;
  double worst_claim = 0.0;
  double first_claim_s = std::numeric_limits<double>::infinity();
};

Told calibrate(const SimulatedCase& simulated, const SimulatedRecord& record, int most) {
  CalibratorConfig config = testing::calibratorConfig();
  config.max_lights = most;
  config.initializer.batch.errors = simulated.looked_for;
  config.initializer.noise = simulated.noise_looked_for;
  Calibrator calibrator(config);
  Told told;
  for (double second = 0.0; second < simulated.duration_s; second += 1.0) {
    told.result = testing::play(record, &calibrator, {0.0}, second, second + 1.0);
    if (told.result.state != CalibrationState::kConverged) continue;
    told.first_claim_s = std::min(told.first_claim_s, second);
    const double chi_square =
        testing::mountChiSquare(*told.result.base_from_sensor, simulated.robot.base_from_sensor);
    told.worst_claim = std::max(told.worst_claim, chi_square);
  }
  return told;
}

int lightsInEstimate(const CalibrationResult& result) {
  int count = 0;
  for (const LightSummary& light : result.lights) count += light.in_estimate ? 1 : 0;
  return count;
}

TEST(SeveralLights, ConvergeSoonerThanOneAndToTheTruth) {
  SimulatedCase simulated = danceWith(2, 3);
  simulated.duration_s = 60.0;
  const SimulatedRecord record = simulate(simulated).record;
  const Told one = calibrate(simulated, record, 1);
  const Told two = calibrate(simulated, record, 2);
  EXPECT_EQ(two.result.state, CalibrationState::kConverged) << two.result.advice;
  EXPECT_LT(two.first_claim_s, one.first_claim_s);
  EXPECT_LT(two.worst_claim, kWrongChiSquare);
  EXPECT_EQ(lightsInEstimate(two.result), 2);
  EXPECT_GT(two.result.rival.minima, 0);
  EXPECT_FALSE(two.result.rival.isOpen());
  EXPECT_EQ(two.result.lights[0].light_id, 0);
  EXPECT_EQ(two.result.lights[1].light_id, 1);
  // both lights are where they are, seen from the base at the end: by their own ellipses
  for (std::size_t i = 0; i < 2; ++i) {
    const CartesianEstimate& light = *two.result.lights[i].cartesian_state;
    const Eigen::Matrix2d covariance = light.covariance.topLeftCorner<2, 2>();
    const Eigen::Vector2d error = light.lightInBase() - record.world_from_base.back().inverse() *
                                                            simulated.lights[i].position_m;
    EXPECT_LT(error.dot(covariance.ldlt().solve(error)), chiSquareQuantile(0.9999, 2.0)) << i;
  }
}

TEST(SeveralLights, OfATiltedSensorHaveAHeightEach) {
  SimulatedCase simulated = danceWith(3, 1);
  simulated.duration_s = 50.0;
  ImperfectRobot how;
  how.tilt_rad = radiansFromDegrees(2.0);
  makeImperfect(simulated, how, 1);
  simulated.robot.sensor.elevation_stddev_rad = radiansFromDegrees(1.0);
  spreadHeights(simulated, 0.4);
  simulated.looked_for.setBlock(SensorTilt::kName, 0.035);
  const Told told = calibrate(simulated, simulate(simulated).record, 3);
  EXPECT_EQ(told.result.state, CalibrationState::kConverged) << told.result.advice;
  EXPECT_LT(told.worst_claim, kWrongChiSquare);
  ASSERT_EQ(lightsInEstimate(told.result), 3);
  for (int i = 0; i < 3; ++i) {
    const auto id = told.result.lights[static_cast<std::size_t>(i)].light_id;
    const double truth_m = simulated.lights[static_cast<std::size_t>(id)].height_m;
    const double variance_m2 = told.result.robot_errors.covariance(heightAt(i), heightAt(i));
    const double off_m = told.result.robot_errors.mean(heightAt(i)) - truth_m;
    EXPECT_LT(off_m * off_m / variance_m2, chiSquareQuantile(0.9999, 1.0)) << "light " << id;
    EXPECT_LT(variance_m2, 0.05 * 0.05);
  }
}

// What a full record gives away is as good as the record itself: so much of the bound at most do
// they differ by, and their covariances by what was linearised elsewhere.
TEST(SeveralLights, ForgetNothingOfALongDrive) {
  constexpr double kMostOff = 0.45;  // of a standard deviation
  SimulatedCase simulated = danceWith(3, 8);
  simulated.duration_s = 200.0;
  const SimulatedRecord record = simulate(simulated).record;
  const auto mountBy = [&](std::size_t capacity) {
    CalibratorConfig config = testing::calibratorConfig();
    config.max_lights = 3;
    config.refit_growth = 0.1;
    config.initializer.record.capacity = capacity;
    Calibrator calibrator(config);
    const CalibrationResult result =
        testing::play(record, &calibrator, {0.0}, 0.0, simulated.duration_s);
    EXPECT_EQ(result.state, CalibrationState::kConverged) << result.advice;
    EXPECT_EQ(lightsInEstimate(result), 3);
    return *result.base_from_sensor;
  };
  const MountEstimate whole = mountBy(10000);
  const MountEstimate short_record = mountBy(400);
  const Eigen::Vector3d stddev = whole.covariance.diagonal().cwiseSqrt();
  const Eigen::Vector3d short_stddev = short_record.covariance.diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(short_record.mean(i), whole.mean(i), kMostOff * stddev(i)) << i;
    EXPECT_NEAR(short_stddev(i) / stddev(i), 1.0, 0.1) << i;
  }
}

/// Leaves those lights alone in the images of [from_s, to_s).
void showOnly(const std::set<std::int32_t>& lights, double from_s, double to_s,
              SimulatedRecord* record) {
  const auto is_hidden = [&](const Bearing& bearing) {
    return lights.count(bearing.light_id) == 0;
  };
  const auto from = record->bearings.begin() + std::lround(from_s * kImages_hz);
  for (auto image = from; image != record->bearings.begin() + std::lround(to_s * kImages_hz);
       ++image) {
    std::vector<Bearing>& seen = image->candidates;
    seen.erase(std::remove_if(seen.begin(), seen.end(), is_hidden), seen.end());
  }
}

/// A drive in which the mount is displaced at some time.
SimulatedRecord displacedAt(double displaced_s, SimulatedCase simulated) {
  SimulatedRecord record = simulate(simulated).record;
  simulated.robot.base_from_sensor.position_m.x() += 0.03;
  simulated.robot.base_from_sensor.yaw_rad += radiansFromDegrees(8.0);
  const SimulatedRecord after = simulate(simulated).record;
  const std::ptrdiff_t first = std::lround(displaced_s * kImages_hz);
  std::copy(after.bearings.begin() + first, after.bearings.end(), record.bearings.begin() + first);
  return record;
}

/// Plays a record in which the mount is displaced while only one light is in view.
void expectThatTheMountHasMoved(const SimulatedRecord& record, double displaced_s, double end_s,
                                Calibrator* calibrator) {
  constexpr double kNoticed_s = 100.0;  // 10 m of way (faults.md)
  testing::play(record, calibrator, {0.0}, 0.0, displaced_s);
  ASSERT_EQ(calibrator->result().state, CalibrationState::kConverged);
  for (double second = displaced_s; second < end_s; second += 1.0) {
    const CalibrationResult result = testing::play(record, calibrator, {0.0}, second, second + 1.0);
    if (second > displaced_s + kNoticed_s) {
      EXPECT_NE(result.state, CalibrationState::kConverged) << second << " s: " << result.advice;
    }
  }
  const CalibrationResult result = calibrator->result();
  EXPECT_EQ(result.state, CalibrationState::kInconsistent) << result.advice;
  EXPECT_EQ(result.cause, Fault::kMountMoved) << result.advice;
}

// The others are out of view for longer than the record that all share, and are no witnesses.
// Promise honest: a mount that is displaced while one of several lights is in view
TEST(SeveralLights, OneThatIsInViewSaysThatTheMountHasMoved) {
  constexpr double kDisplaced_s = 60.0;
  SimulatedCase simulated = danceWith(3, 8);
  simulated.duration_s = kDisplaced_s + 500.0;
  SimulatedRecord record = displacedAt(kDisplaced_s, simulated);
  // seen once more in between: what is cut off ends before it
  const std::ptrdiff_t last = std::lround((kDisplaced_s - 0.5) * kImages_hz);
  const BearingSet last_of_all = record.bearings[last];
  showOnly({0}, kDisplaced_s - 1.0, simulated.duration_s, &record);
  record.bearings[last] = last_of_all;

  CalibratorConfig config = testing::calibratorConfig();
  config.max_lights = 3;
  config.initializer.record.capacity = 300;
  Calibrator calibrator(config);
  expectThatTheMountHasMoved(record, kDisplaced_s, simulated.duration_s, &calibrator);
}

// Some of its bearings scatter more for a while than a displacement alone would explain.
// Promise honest: bearings that scatter after the mount was displaced
TEST(SeveralLights, OneThatHasSaidThatTheMountHasMovedDoesNotTakeItBack) {
  constexpr double kDisplaced_s = 150.0;
  SimulatedCase simulated = danceWith(3, 9);
  simulated.duration_s = kDisplaced_s + 140.0;
  SimulatedRecord record = displacedAt(kDisplaced_s, simulated);
  showOnly({0}, kDisplaced_s - 60.0, simulated.duration_s, &record);
  CalibratorConfig config = testing::calibratorConfig();
  config.max_lights = 3;
  Calibrator calibrator(config);
  expectThatTheMountHasMoved(record, kDisplaced_s, simulated.duration_s, &calibrator);
}

// They would not notice that the mount is displaced. While nothing is in view nobody is in doubt.
// Promise honest: lights out of view while another one, not in the estimate, is in view
TEST(SeveralLights, OutOfViewDoNotSpeakForTheOneInView) {
  constexpr double kVanish_s = 60.0;
  constexpr double kAppears_s = 200.0;
  SimulatedCase simulated = danceWith(3, 8);
  simulated.duration_s = 300.0;
  SimulatedRecord record = simulate(simulated).record;
  showOnly({0, 1}, 0.0, kVanish_s, &record);
  showOnly({}, kVanish_s, kAppears_s, &record);
  showOnly({2}, kAppears_s, simulated.duration_s, &record);
  CalibratorConfig config = testing::calibratorConfig();
  config.max_lights = 3;
  Calibrator calibrator(config);
  const CalibrationResult before = testing::play(record, &calibrator, {0.0}, 0.0, kAppears_s);
  EXPECT_EQ(before.state, CalibrationState::kConverged) << before.advice;
  const CalibrationResult seen =
      testing::play(record, &calibrator, {0.0}, kAppears_s, kAppears_s + 1.0);
  EXPECT_EQ(seen.state, CalibrationState::kConverging) << seen.advice;
  const CalibrationResult after = testing::play(record, &calibrator, {0.0}, kAppears_s + 1.0);
  EXPECT_EQ(after.state, CalibrationState::kConverged) << after.advice;
  EXPECT_TRUE(after.lights.back().in_estimate);
}

TEST(SeveralLights, AreToldApartWithoutNumbers) {
  SimulatedCase simulated = danceWith(2, 4);
  simulated.duration_s = 80.0;
  simulated.robot.sensor.identifies_lights = false;
  const Told told = calibrate(simulated, simulate(simulated).record, 2);
  EXPECT_EQ(told.result.state, CalibrationState::kConverged) << told.result.advice;
  EXPECT_EQ(lightsInEstimate(told.result), 2);
  EXPECT_LT(told.worst_claim, kWrongChiSquare);
}

// Noise that is larger than stated takes lights off where they are expected, and is no slip.
TEST(SeveralLights, WithoutNumbersAreKnownAsWellWhateverIsStatedOfTheirNoise) {
  Eigen::Array3d ratios = Eigen::Array3d::Zero();  // of the standard deviations
  const std::vector<std::uint64_t> seeds = {2, 4, 7};
  for (const std::uint64_t seed : seeds) {
    SimulatedCase simulated = danceWith(3, seed);
    simulated.duration_s = 80.0;
    simulated.noise_looked_for = usualNoise();
    simulated.robot.sensor.identifies_lights = false;
    SimulatedRecord record = simulate(simulated).record;
    const Told honest = calibrate(simulated, record, 3);
    for (BearingSet& image : record.bearings) {
      for (Bearing& bearing : image.candidates) bearing.azimuth_variance_rad2 /= 9.0;
    }
    const Told understated = calibrate(simulated, record, 3);
    ASSERT_TRUE(honest.result.base_from_sensor && understated.result.base_from_sensor);
    EXPECT_EQ(lightsInEstimate(understated.result), 3);
    EXPECT_LT(understated.worst_claim, kWrongChiSquare);
    ratios += (understated.result.base_from_sensor->covariance.diagonal().array() /
               honest.result.base_from_sensor->covariance.diagonal().array())
                  .sqrt();
  }
  EXPECT_LT((ratios / static_cast<double>(seeds.size())).maxCoeff(), 1.2) << ratios;
}

// Lights that pass each other, and slips after which each is seen elsewhere: where one could be
// another it is not taken for it.
// Promise honest: lights without numbers that pass each other
TEST(SeveralLights, AreNotMixedUpWithoutNumbers) {
  for (const auto& [seed, slips] : {std::pair(105, 0), std::pair(13, 3)}) {
    SimulatedCase simulated = danceWith(4, static_cast<std::uint64_t>(seed));
    simulated.robot.sensor.identifies_lights = false;
    addSlips(simulated, slips, static_cast<std::uint64_t>(seed));
    const SimulatedRecord record = simulate(simulated).record;
    simulated.duration_s = 70.0;
    const Told told = calibrate(simulated, record, 4);
    EXPECT_LT(told.worst_claim, kWrongChiSquare) << seed;
    EXPECT_LT(told.first_claim_s, simulated.duration_s) << seed;
  }
}

// A slip turns the base by a quarter of a radian, and all lights against what they are expected at:
// nothing that was seen of them is given up.
TEST(SeveralLights, WithoutNumbersAreFollowedThroughASlip) {
  SimulatedCase simulated = danceWith(4, 2);
  simulated.duration_s = 60.0;
  simulated.robot.sensor.identifies_lights = false;
  simulated.robot.faults.slips = {{{40.0, 0.4}, WheelSlip::Wheel::kLeft, 0.7}};
  const SimulatedRecord record = simulate(simulated).record;
  CalibratorConfig config = testing::calibratorConfig();
  config.max_lights = 4;
  Calibrator calibrator(config);
  int given_up = 0;
  calibrator.observe([&](const AssociationOutcome& outcome) { given_up += outcome.lost_light; });
  const CalibrationResult result = testing::play(record, &calibrator);
  EXPECT_EQ(given_up, 0);
  EXPECT_EQ(lightsInEstimate(result), 4) << result.advice;
  EXPECT_LT(testing::mountChiSquare(*result.base_from_sensor, simulated.robot.base_from_sensor),
            kWrongChiSquare);
}

TEST(SeveralLights, ThatAreSeenTooCloseTogetherAreSaidToBe) {
  SimulatedCase simulated = danceWith(2, 104);
  simulated.duration_s = 20.0;
  simulated.robot.sensor.identifies_lights = false;
  const Told told = calibrate(simulated, simulate(simulated).record, 2);
  EXPECT_EQ(told.result.state, CalibrationState::kWaitingForLight);
  EXPECT_NE(told.result.advice.find("too close to each other"), std::string::npos)
      << told.result.advice;
}

// 2 cm/s is more than a metre in the whole run; 2 mm/s is so little that the light alone may
// believe it.
// Promise honest: one of two lights that moves
TEST(SeveralLights, OneOfTwoThatMovesIsNeverBelievedWrongly) {
  for (const double speed_mps : {0.002, 0.02}) {
    SimulatedCase simulated = danceWith(2, 5);
    simulated.duration_s = 60.0;
    simulated.lights[1].velocity_mps = {speed_mps, 0.5 * speed_mps};
    const Told told = calibrate(simulated, simulate(simulated).record, 2);
    EXPECT_LT(told.worst_claim, kWrongChiSquare) << speed_mps;
  }
}

// A light whose place another one takes while it is hidden, and one that pulls the mount before it
// is found out.
TEST(SeveralLights, HiddenInTurnOrMovingAreNeverBelievedWronglyWithoutNumbers) {
  SimulatedCase hidden = danceWith(4, 46);
  hidden.hide_in_turn_s = 5.0;
  SimulatedCase moving = danceWith(4, 30);
  moving.lights.back().velocity_mps.x() = 0.02;
  for (SimulatedCase* simulated : {&hidden, &moving}) {
    simulated->are_lights_told = false;
    const Trial trial = tryCalibrator(*simulated, {simulated->duration_s});
    EXPECT_TRUE(trial.first_claim_s.has_value());
    EXPECT_LT(trial.worst_claim, kWrongChiSquare);
  }
}

TEST(SeveralLights, OneOfThreeThatMovesIsLeftOutAndSaid) {
  SimulatedCase simulated = danceWith(3, 7);
  simulated.duration_s = 60.0;
  simulated.lights[1].velocity_mps = {0.01, 0.0};
  const Told told = calibrate(simulated, simulate(simulated).record, 3);
  EXPECT_LT(told.worst_claim, kWrongChiSquare);
  EXPECT_EQ(told.result.state, CalibrationState::kConverged) << told.result.advice;
  EXPECT_EQ(lightsInEstimate(told.result), 2);
  EXPECT_FALSE(told.result.lights[1].in_estimate);
  EXPECT_FALSE(told.result.lights[1].note.empty());
}

// Lights come and go: the second is first seen after half a minute, the first one not any more.
TEST(SeveralLights, MayAppearAndVanishAtAnyTime) {
  const SimulatedCase simulated = danceWith(2, 8);
  SimulatedRecord record = simulate(simulated).record;
  for (std::size_t i = 0; i < record.bearings.size(); ++i) {
    std::vector<Bearing>& candidates = record.bearings[i].candidates;
    if (i < 300) candidates.erase(candidates.begin() + 1);
    if (i >= 600) candidates.erase(candidates.begin());
  }
  const Told told = calibrate(simulated, record, 2);
  EXPECT_EQ(told.result.state, CalibrationState::kConverged) << told.result.advice;
  EXPECT_EQ(lightsInEstimate(told.result), 2);
  EXPECT_LT(told.worst_claim, kWrongChiSquare);
}

TEST(SeveralLights, OneAtMostIsTheFirstLightAlone) {
  SimulatedCase simulated = danceWith(2, 9);
  simulated.duration_s = 30.0;
  SimulatedRecord record = simulate(simulated).record;
  const Told both = calibrate(simulated, record, 1);
  for (BearingSet& set : record.bearings) set.candidates.pop_back();
  const Told first = calibrate(simulated, record, 1);
  EXPECT_EQ(both.result.cartesian_state->mean, first.result.cartesian_state->mean);
  EXPECT_EQ(both.result.cartesian_state->covariance, first.result.cartesian_state->covariance);
}

}  // namespace
}  // namespace bearing_calibration::core
