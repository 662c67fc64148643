#include "bearing_calibration/calibration/record_review.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/chi_square.h"
#include "support/simulated_calibration.h"

namespace bearing_calibration {
namespace {

using testing::calibratorConfig;
using testing::mountChiSquare;
using testing::paperRobot;
using testing::play;
using testing::simulate;

constexpr double kDuration_s = 60.0;

/// A record that went through a calibrator, with its review.
struct Reviewed {
  explicit Reviewed(const SimulatedRecord& record, double to_s = kDuration_s) {
    Calibrator calibrator(calibratorConfig());
    RecordReview looked(calibratorConfig().initializer);
    calibrator.observe([&](const Look& look) { looked.add(look); });
    result = play(record, &calibrator, {0.0}, 0.0, to_s);
    std::optional<RobotEstimate> running;
    if (result.cartesian_state) running = {*result.cartesian_state, result.robot_errors};
    review = looked.conclude(running);
    from_nothing = looked.conclude(std::nullopt);
  }

  CalibrationResult result;
  Review review;
  Review from_nothing;
};

TEST(RecordReview, EndsAtTheTruthWithinItsCovariance) {
  const RobotConfig robot = paperRobot(1);
  const Reviewed reviewed(simulate(robot, kDuration_s));
  ASSERT_TRUE(reviewed.review.settled);
  EXPECT_LT(mountChiSquare(mountFromCartesian(reviewed.review.estimate->cartesian),
                           robot.base_from_sensor),
            chiSquareQuantile(0.999, 3.0));
}

// The running calibration has already refined itself by the same record: the review adds no answer
// of its own.
TEST(RecordReview, AgreesWithTheRunningCalibration) {
  const Reviewed reviewed(simulate(paperRobot(2), kDuration_s));
  const MountEstimate review = mountFromCartesian(reviewed.review.estimate->cartesian);
  const MountEstimate& running = *reviewed.result.base_from_sensor;
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(review.mean(i) - running.mean(i)), std::sqrt(running.covariance(i, i)));
  }
  ASSERT_TRUE(reviewed.from_nothing.estimate.has_value());
  EXPECT_LT(
      (mountFromCartesian(reviewed.from_nothing.estimate->cartesian).mean - review.mean).norm(),
      1e-4);
}

TEST(RecordReview, JudgesEveryImage) {
  const SimulatedRecord record = simulate(paperRobot(3), kDuration_s);
  const Reviewed reviewed(record);
  int used = 0;
  double nis_sum = 0.0;
  for (const ReviewedLook& look : reviewed.review.looks) {
    if (look.verdict != Verdict::kUsed) continue;
    ++used;
    nis_sum += look.nis;
    EXPECT_LT(std::abs(look.residual_rad), 6.0 * std::sqrt(look.look.sight.azimuth_variance_rad2));
  }
  EXPECT_EQ(reviewed.review.looks.size(), reviewed.result.bearing_inputs[InputStatus::kAccepted]);
  EXPECT_GT(used, 0.95 * static_cast<double>(reviewed.review.looks.size()));
  EXPECT_NEAR(nis_sum / used, 1.0, 5.0 * std::sqrt(2.0 / used));
}

TEST(RecordReview, MarksAnOutlier) {
  SimulatedRecord record = simulate(paperRobot(4), kDuration_s);
  const std::size_t false_one = record.bearings.size() / 2;
  record.bearings[false_one].candidates.front().azimuth_rad += 1.0;
  const Stamp stamp = record.bearings[false_one].stamp;
  const Reviewed reviewed(record);
  bool found = false;
  for (const ReviewedLook& look : reviewed.review.looks) {
    if (look.look.sight.stamp != stamp) continue;
    found = true;
    EXPECT_EQ(look.verdict, Verdict::kLeftOut);
    EXPECT_NEAR(look.residual_rad, 1.0, 0.1);
    EXPECT_TRUE(std::isnan(look.nis));
  }
  EXPECT_TRUE(found);
}

TEST(RecordReview, WithoutAnEstimateNothingIsJudged) {
  constexpr double kTooShort_s = 3.0;  // one straight line
  const Reviewed reviewed(simulate(paperRobot(5), kDuration_s), kTooShort_s);
  EXPECT_FALSE(reviewed.review.estimate.has_value());
  EXPECT_NE(reviewed.review.start.obstacle, StartObstacle::kNone);
  ASSERT_FALSE(reviewed.review.looks.empty());
  for (const ReviewedLook& look : reviewed.review.looks) {
    EXPECT_EQ(look.verdict, Verdict::kUnjudged);
    EXPECT_TRUE(std::isnan(look.residual_rad));
  }
}

TEST(RecordReview, ALostLightStartsItAnew) {
  RecordReview review(calibratorConfig().initializer);
  Look look;
  look.kind = Look::Kind::kTaken;
  look.sight.azimuth_variance_rad2 = 1e-4;
  for (int i = 0; i < 3; ++i) {
    look.sight.stamp = stampFromSeconds(1.0 + i);
    look.lost_light = i == 2;
    review.add(look);
  }
  EXPECT_EQ(review.conclude(std::nullopt).looks.size(), 1U);
}

}  // namespace
}  // namespace bearing_calibration
