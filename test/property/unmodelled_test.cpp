// What a study's robots are that no model knows: each against its closed form.

#include "tools/study/unmodelled.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/common/chi_square.h"

namespace bearing_calibration::core {
namespace {

using Kind = TrajectoryConfig::Kind;

constexpr double kDuration_s = 60.0;
constexpr double kSpeed_mps = 0.2;

SimulatedCase quietCase(Unmodelled what, Kind kind) {
  SimulatedCase simulated = paperCase(1);
  simulated.robot.encoders.noise = {0.0, 0.0};
  simulated.trajectory.kind = kind;
  simulated.trajectory.wheel_speed_mps = kSpeed_mps;
  simulated.duration_s = kDuration_s;
  makeUnmodelled(what, simulated);
  return simulated;
}

/// What the counters say that left and right have rolled until then.
WheelDisplacement reported(Unmodelled what, Kind kind, double until_s) {
  const SimulatedCase simulated = quietCase(what, kind);
  const DriveGeometry& drive = simulated.robot.encoders.drive;
  const SimulatedRecord record = simulate(simulated).record;
  const Stamp end = record.ticks.front().stamp + durationFromSeconds(until_s);
  WheelDisplacement rolled_m;
  for (const WheelCounts& ticks : record.ticks) {
    if (ticks.stamp > end) break;
    rolled_m = {drive.leftMetersPerTick() * static_cast<double>(ticks.left_ticks),
                drive.rightMetersPerTick() * static_cast<double>(ticks.right_ticks)};
  }
  return rolled_m;
}

// Over half a swing the mean of the sine is 2 / pi.
TEST(Unmodelled, ASeparationThatSwingsTakesATurnForMore) {
  constexpr double kHalfSwing_s = 18.5;
  const WheelDisplacement rolled =
      reported(Unmodelled::kSwingingSeparation, Kind::kSpin, kHalfSwing_s);
  EXPECT_NEAR(rolled.right_m / (kSpeed_mps * kHalfSwing_s), 1.0 + 0.03 * 2.0 / kPi, 2e-4);
  EXPECT_NEAR(rolled.left_m, -rolled.right_m, 1e-4);
}

TEST(Unmodelled, ASenseOfTurnTakesATurnToTheLeftForMore) {
  const WheelDisplacement rolled = reported(Unmodelled::kSenseOfTurn, Kind::kSpin, kDuration_s);
  EXPECT_NEAR(rolled.right_m / (kSpeed_mps * kDuration_s), 1.0075, 1e-4);
}

TEST(Unmodelled, ATyreThatDriftsIsLargerByHalfOfItInTheMean) {
  const WheelDisplacement rolled = reported(Unmodelled::kDriftingTyre, Kind::kLine, kDuration_s);
  EXPECT_NEAR(rolled.left_m / rolled.right_m, 1.003, 1e-4);
}

TEST(Unmodelled, CoarseTicksAreMillimetres) {
  const SimulatedCase simulated = quietCase(Unmodelled::kCoarseTicks, Kind::kLine);
  EXPECT_NEAR(simulated.robot.encoders.drive.leftMetersPerTick(), 1e-3, 1e-12);
}

// 12 m straight over 24 stripes: half of the way has the stated variance K a metre, half 25 K.
TEST(Unmodelled, TwoGripsHaveTheVarianceOfBoth) {
  constexpr int kRuns = 100;
  constexpr double kWay_m = kSpeed_mps * kDuration_s;
  constexpr double kVariancePerMetre_m = 1e-6;
  const double variance_m2 = 0.5 * kWay_m * (1.0 + 25.0) * kVariancePerMetre_m;
  double chi_square = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = quietCase(Unmodelled::kTwoGrips, Kind::kLine);
    simulated.robot.encoders.noise.independent_k_m = kVariancePerMetre_m;
    simulated.robot.seed = seed;
    const WheelCounts last = simulate(simulated).record.ticks.back();
    const double left_m =
        simulated.robot.encoders.drive.leftMetersPerTick() * static_cast<double>(last.left_ticks);
    chi_square += std::pow(left_m - kWay_m, 2) / variance_m2;
  }
  EXPECT_GT(chi_square, chiSquareQuantile(0.001, kRuns));
  EXPECT_LT(chi_square, chiSquareQuantile(0.999, kRuns));
}

/// Mean square of the bearings' noise, in its stated variance, and the share beyond three stated
/// standard deviations.
struct Noise {
  double mean_square = 0.0;
  double beyond = 0.0;
};

Noise noiseOf(Unmodelled what) {
  SimulatedCase simulated = quietCase(what, Kind::kDance);
  simulated.duration_s = 2000.0;
  const ObservationRun run = simulate(simulated);
  const auto count = static_cast<double>(run.observations.size());
  Noise noise;
  for (std::size_t i = 0; i < run.observations.size(); ++i) {
    const Observation& observation = run.observations[i];
    const double residual_rad = residualOf(observation, run.truth[i], ErrorVector::Zero());
    const double square = residual_rad * residual_rad / observation.azimuth_variance_rad2;
    noise.mean_square += square / count;
    noise.beyond += (square > 9.0 ? 1.0 : 0.0) / count;
  }
  return noise;
}

// Of 20000: 2 (1 - F(3 sqrt 3)) of Student's t with 3 degrees is 0.0138, of a Gaussian 0.0027. The
// fourth moment of the former is infinite: its mean square is told to some per cent only.
TEST(Unmodelled, HeavyTailsAreThoseOfStudentsT) {
  const Noise tails = noiseOf(Unmodelled::kHeavyTails);
  EXPECT_NEAR(tails.beyond, 0.0138, 4.0 * std::sqrt(0.0138 / 20000.0));
  EXPECT_NEAR(tails.mean_square, 1.0, 0.3);
  EXPECT_NEAR(noiseOf(Unmodelled::kNone).beyond, 0.0027, 4.0 * std::sqrt(0.0027 / 20000.0));
}

TEST(Unmodelled, NamesAreThoseOfTheList) {
  EXPECT_EQ(unmodelledFrom("two_grips"), Unmodelled::kTwoGrips);
  EXPECT_EQ(unmodelledNames().size(), static_cast<std::size_t>(Unmodelled::kLaterTicks) + 1U);
  EXPECT_THROW(unmodelledFrom("moon"), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
