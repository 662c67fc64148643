#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "bearing_calibration/output/result_store.h"
#include "support/some_calibration.h"

namespace bearing_calibration::core {

// GoogleTest prints by it.
void PrintTo(SavingDecision decision, std::ostream* out) {
  const char* const kNames[] = {"replaces", "takes place", "gives way"};
  *out << kNames[static_cast<int>(decision)];
}

namespace {

using State = CalibrationState;
constexpr auto kReplaces = SavingDecision::kReplaces;
constexpr auto kTakesPlace = SavingDecision::kTakesPlace;
constexpr auto kGivesWay = SavingDecision::kGivesWay;

constexpr ConvergenceConfig kTargets{0.01, 0.005};

/// Of one mount, with this standard deviation of all three as a multiple of its target.
SavedCalibration resultOf(State state, double worst) {
  SavedCalibration saved = someCalibration();
  saved.result.state = state;
  saved.result.base_from_sensor->covariance =
      Eigen::Vector3d(kTargets.position_stddev_m, kTargets.position_stddev_m,
                      kTargets.yaw_stddev_rad)
          .cwiseAbs2()
          .asDiagonal();
  saved.result.base_from_sensor->covariance *= worst * worst;
  return saved;
}

/// Which of two results of one mount stays.
struct Row {
  State old_state;
  double old_worst;
  State fresh_state;
  double fresh_worst;
  SavingDecision expected;
};

TEST(SavingRule, ForOneMountTheBetterStateThenTheSmallerWorstStddev) {
  const std::vector<Row> table = {
      {State::kConverged, 0.8, State::kConverging, 0.1, kGivesWay},
      {State::kConverged, 0.8, State::kInitialising, 0.1, kGivesWay},
      {State::kConverged, 0.8, State::kInconsistent, 0.1, kGivesWay},
      {State::kConverging, 2.0, State::kInitialising, 0.1, kGivesWay},
      {State::kConverging, 2.0, State::kDegenerateMotion, 0.1, kGivesWay},
      {State::kConverging, 0.1, State::kConverged, 0.8, kReplaces},
      {State::kInitialising, 0.1, State::kConverging, 2.0, kReplaces},
      {State::kInconsistent, 0.1, State::kConverged, 0.8, kReplaces},
      {State::kConverged, 0.5, State::kConverged, 0.4, kReplaces},
      {State::kConverged, 0.4, State::kConverged, 0.5, kGivesWay},
      {State::kConverged, 0.4, State::kConverged, 0.4, kReplaces},
      {State::kConverging, 2.0, State::kConverging, 1.0, kReplaces},
      {State::kConverging, 1.0, State::kConverging, 2.0, kGivesWay},
      {State::kInitialising, 2.0, State::kDegenerateMotion, 1.0, kReplaces},
      {State::kDegenerateMotion, 1.0, State::kInitialising, 2.0, kGivesWay},
  };
  for (const Row& row : table) {
    const auto verdict = judgeSaving(resultOf(row.old_state, row.old_worst),
                                     resultOf(row.fresh_state, row.fresh_worst), kTargets, false);
    EXPECT_EQ(verdict.decision, row.expected)
        << nameOf(row.old_state) << " " << row.old_worst << " there, " << nameOf(row.fresh_state)
        << " " << row.fresh_worst << " new: " << verdict.why;
  }
}

// The worst of the three counts, each by its own target: 3 mm of 10 is less than 2 mrad of 5.
TEST(SavingRule, StandardDeviationsAreHeldAgainstTheirTargets) {
  SavedCalibration by_yaw = resultOf(State::kConverged, 0.1);
  by_yaw.result.base_from_sensor->covariance(2, 2) = 2e-3 * 2e-3;
  SavedCalibration by_y = resultOf(State::kConverged, 0.1);
  by_y.result.base_from_sensor->covariance(1, 1) = 3e-3 * 3e-3;
  EXPECT_EQ(judgeSaving(by_yaw, by_y, kTargets, false).decision, kReplaces);
  EXPECT_EQ(judgeSaving(by_y, by_yaw, kTargets, false).decision, kGivesWay);
  const ConvergenceConfig lax_yaw{0.01, 0.05};
  EXPECT_EQ(judgeSaving(by_y, by_yaw, lax_yaw, false).decision, kReplaces);
}

// Chi-square with 3 degrees of freedom stays below 21.108 with the probability 1 - 1e-4. Where the
// standard deviations of both are 10 mm, that is a difference of sqrt(2 * 21.108) * 10 mm in x.
TEST(SavingRule, AContradictionKeepsBoth) {
  for (const State state : {State::kConverging, State::kConverged}) {
    const SavedCalibration old = resultOf(State::kConverged, 1.0);
    SavedCalibration fresh = resultOf(state, 1.0);
    const double limit_m = std::sqrt(2.0 * 21.108) * 0.01;
    fresh.result.base_from_sensor->mean.x() += 1.001 * limit_m;
    const auto verdict = judgeSaving(old, fresh, kTargets, false);
    EXPECT_EQ(verdict.decision, kTakesPlace);
    EXPECT_NE(verdict.why.find("contradicts"), std::string::npos) << verdict.why;
    fresh = resultOf(state, 2.0);
    EXPECT_EQ(judgeSaving(old, fresh, kTargets, false).decision, kGivesWay) << "it may be so";
    fresh = resultOf(state, 1.0);
    fresh.result.base_from_sensor->mean.x() += 0.999 * limit_m;
    EXPECT_NE(judgeSaving(old, fresh, kTargets, false).decision, kTakesPlace);
  }
}

TEST(SavingRule, AWholeTurnIsNoContradiction) {
  SavedCalibration old = resultOf(State::kConverged, 1.0), fresh = old;
  old.result.base_from_sensor->mean.z() = 3.1415;
  fresh.result.base_from_sensor->mean.z() = -3.1415;
  EXPECT_EQ(judgeSaving(old, fresh, kTargets, false).decision, kReplaces);
}

TEST(SavingRule, AfterAResetBothAreKept) {
  const auto verdict = judgeSaving(resultOf(State::kConverged, 0.1),
                                   resultOf(State::kConverging, 2.0), kTargets, true);
  EXPECT_EQ(verdict.decision, kTakesPlace);
  EXPECT_NE(verdict.why.find("reset"), std::string::npos) << verdict.why;
}

TEST(SavingRule, WhatMayNotBeTrustedTakesNobodysPlace) {
  SavedCalibration wrong = resultOf(State::kInconsistent, 0.1);
  wrong.result.base_from_sensor->mean.x() += 1.0;
  for (const State state : {State::kConverging, State::kConverged}) {
    for (const bool was_reset : {false, true}) {
      EXPECT_EQ(judgeSaving(resultOf(state, 1.0), wrong, kTargets, was_reset).decision, kGivesWay);
    }
  }
}

TEST(SavingRule, AnotherRobotsResultIsKept) {
  std::vector<SavedCalibration> others(5, resultOf(State::kConverged, 0.1));
  others[0].base_frame = "base_footprint";
  others[1].sensor_frame = "laser";
  others[2].provenance.drive.wheel_separation_m *= 1.01;
  others[3].provenance.drive.left_wheel_radius_m *= 1.01;
  others[4].provenance.drive.right_wheel_radius_m *= 1.01;
  for (const SavedCalibration& other : others) {
    const auto verdict = judgeSaving(other, resultOf(State::kConverging, 2.0), kTargets, false);
    EXPECT_EQ(verdict.decision, kTakesPlace) << verdict.why;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
