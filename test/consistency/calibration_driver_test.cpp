// A robot that drives its own calibration: when it stops, and that it arrives.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include "tools/study/drive_summary.h"

namespace bearing_calibration::core {
namespace {

constexpr double kPeriod_s = 0.05;
constexpr double kAcceleration = 1.0;  // of the wheels [m/s^2], as paperDrive() has it
const DriveGoal kLongDrive{DriveMotion::kDance, 1000.0, 1000.0};

/// A robot whose wheels do what they are told at once, and whose inputs can be taken away.
class Robot {
 public:
  explicit Robot(const DriveGoal& goal = kLongDrive, const DriveConfig& config = paperDrive())
      : separation_m_(config.limits.wheel_separation_m), driver_(config, goal, now_) {}

  bool has_ticks = true, sends_images = true, sees_light = true, has_estimate = true;
  bool sees_another = false;  ///< that is known to be none of the calibration's lights
  double probability = 1.0;   ///< of the light
  FieldOfView view;           ///< as the sensor says it
  bool wheels_roll = true;
  CalibrationState state = CalibrationState::kInitialising;
  std::optional<StateEstimate> estimate;  ///< where the robot is now

  /// Drives for a while; the speeds that were commanded are kept.
  void drive(double time_s) {
    for (double end_s = time_s; end_s > 0.0; end_s -= kPeriod_s) {
      now_ += durationFromSeconds(kPeriod_s);
      if (has_ticks) driver_.addTravel({now_, travel_.left_m, travel_.right_m, 0.0}, now_);
      if (sends_images) driver_.addBearings(image(), now_);
      if (has_estimate) driver_.addEstimate({now_, state, estimate}, now_);
      commands.push_back(driver_.steer(now_));
      if (!wheels_roll) continue;
      travel_.left_m += kPeriod_s * commands.back().left_mps;
      travel_.right_m += kPeriod_s * commands.back().right_mps;
    }
  }

  /// Drives on and expects the end for this reason, within a time, and to stand from then on.
  void expectEnd(DriveEnd reason, double within_s) {
    const std::size_t first = std::max<std::size_t>(commands.size(), 1);
    drive(within_s);
    EXPECT_STREQ(nameOf(driver_.ended()), nameOf(reason));
    drive(0.25);  // 0.2 m/s at 1 m/s^2, and a period
    EXPECT_TRUE(driver_.standing());
    drive(1.0);
    EXPECT_TRUE(isStanding(commands.back()));
    for (std::size_t i = first; i < commands.size(); ++i) {
      EXPECT_LE(std::abs(commands[i].right_mps - commands[i - 1].right_mps),
                kAcceleration * kPeriod_s + 1e-9);
      EXPECT_LE(std::abs(commands[i].left_mps - commands[i - 1].left_mps),
                kAcceleration * kPeriod_s + 1e-9);
    }
  }

  CalibrationDriver& driver() { return driver_; }
  std::vector<WheelSpeeds> commands;

 private:
  BearingSet image() const {
    BearingSet image;
    image.stamp = now_;
    image.view = view;
    if (sees_light) image.candidates.emplace_back().probability = probability;
    if (sees_another) image.candidates.emplace_back().probability = 0.0;
    return image;
  }

  double separation_m_;
  Stamp now_ = stampFromSeconds(100.0);
  CalibrationDriver driver_;
  WheelDisplacement travel_;
};

TEST(CalibrationDriver, StandsUntilWheelsAndCalibrationAreHeard) {
  for (bool Robot::*const input : {&Robot::has_ticks, &Robot::has_estimate}) {
    Robot robot;
    robot.*input = false;
    robot.drive(0.4);
    for (const WheelSpeeds& command : robot.commands) EXPECT_TRUE(isStanding(command));
    robot.*input = true;
    robot.drive(1.0);
    EXPECT_FALSE(robot.driver().standing());
  }
}

TEST(CalibrationDriver, StopsWhenAnInputFallsSilent) {
  Robot ticks, light, estimate;
  for (Robot* robot : {&ticks, &light, &estimate}) {
    robot->drive(2.0);
    ASSERT_FALSE(robot->driver().standing());
  }
  ticks.has_ticks = false;
  light.sees_light = false;
  light.sees_another = true;
  estimate.has_estimate = false;
  for (const auto& [robot, timeout_s, reason] : {std::tuple(&ticks, 0.5, DriveEnd::kTicksLost),
                                                 {&light, 3.0, DriveEnd::kLightLost},
                                                 {&estimate, 3.0, DriveEnd::kEstimateLost}}) {
    robot->drive(timeout_s - 0.1);
    EXPECT_EQ(robot->driver().ended(), DriveEnd::kNone) << nameOf(reason);
    robot->expectEnd(reason, 0.2);
  }
}

// The calibration uses none of them.
TEST(CalibrationDriver, StopsWhereAllCandidatesAreTooUnlikely) {
  DriveConfig config = paperDrive();
  config.min_probability = 0.1;
  Robot robot(kLongDrive, config);
  robot.probability = 0.1;
  robot.drive(5.0);
  ASSERT_FALSE(robot.driver().standing());
  robot.probability = 0.09;
  robot.expectEnd(DriveEnd::kLightLost, 3.1);
}

/// Nothing is known yet: metres are driven with the light out of view, but not a fourth turn, and
/// nothing without images.
TEST(CalibrationDriver, OfALimitedFieldOfViewMissesTheLightInThreeTurnsOnly) {
  const FieldOfView narrow{0.0, 1.0};
  Robot unseen;  // a metre takes 5.2 s, a turn and a quarter 5.1 s: due after 27.9 s
  unseen.view = narrow;
  unseen.drive(0.5);
  unseen.sees_light = false;
  unseen.drive(27.0);
  EXPECT_EQ(unseen.driver().ended(), DriveEnd::kNone);
  unseen.expectEnd(DriveEnd::kLightLost, 5.0);
  Robot blind;
  blind.view = narrow;
  blind.drive(0.5);
  blind.sends_images = false;
  blind.expectEnd(DriveEnd::kLightLost, 3.1);
}

TEST(CalibrationDriver, OfALimitedFieldOfViewMissesTheLightWhereItIsExpected) {
  Robot robot;
  robot.view = {0.0, 1.0};
  CartesianEstimate estimate;
  estimate.mean << 5.0, 0.0, 0.1, 0.0, kPi;  // it looks back, the light is ahead
  estimate.covariance = 1e-4 * Matrix5::Identity();
  robot.estimate = StateEstimate::of(estimate);
  robot.drive(0.5);
  robot.sees_light = false;
  robot.drive(4.0);
  EXPECT_EQ(robot.driver().ended(), DriveEnd::kNone);
  estimate.mean(CartesianIndex::kSensorYaw) = 0.0;
  robot.estimate = StateEstimate::of(estimate);
  robot.expectEnd(DriveEnd::kLightLost, 3.1);
}

// As after ~reset, or when the calibration has lost its light: that still stands where it stood.
TEST(CalibrationDriver, KeepsAwayFromALightWhoseEstimateIsTakenBack) {
  const Eigen::Vector2d light_m(0.55, 0.0);
  Robot robot(DriveGoal{DriveMotion::kOptimal, 1000.0, 1000.0});
  CartesianEstimate estimate;
  estimate.mean << light_m.x(), light_m.y(), 0.1, 0.0, 0.5;
  estimate.covariance = 1e-6 * Matrix5::Identity();
  robot.estimate = StateEstimate::of(estimate);
  robot.drive(0.05);
  robot.estimate.reset();
  for (int i = 0; i < 400; ++i) {
    robot.drive(0.1);
    const Pose2& base = robot.driver().startFromBase();
    ASSERT_GT((base.position_m - light_m).norm(), kNear_m) << 0.1 * i << " s";
  }
  EXPECT_GT(robot.driver().pathMeters(), 1.0) << nameOf(robot.driver().ended());
}

TEST(CalibrationDriver, CountsNoTimeThatStepsBack) {
  CalibrationDriver driver(paperDrive(), kLongDrive, stampFromSeconds(100.0));
  driver.steer(stampFromSeconds(103.0));
  driver.steer(stampFromSeconds(50.0));
  EXPECT_DOUBLE_EQ(driver.timeSeconds(), 3.0);
}

/// Every input then seems to have been silent.
TEST(CalibrationDriver, SaysThatTimeHasSteppedAhead) {
  for (const double real_s : {0.05, 60.0}) {
    CalibrationDriver driver(paperDrive(), kLongDrive, stampFromSeconds(100.0));
    driver.steer(stampFromSeconds(100.05), 0.05);
    driver.steer(stampFromSeconds(160.0), real_s);
    EXPECT_STREQ(nameOf(driver.ended()), real_s < 1.0 ? "CLOCK_LOST" : "TICKS_LOST");
  }
}

TEST(CalibrationDriver, TakesNothingOfAnImpossibleFieldOfView) {
  Robot robot;
  robot.view = {0.0, 60.0};  // in degrees
  robot.expectEnd(DriveEnd::kLightLost, 3.1);
}

TEST(CalibrationDriver, StopsWhenToldToAndKeepsTheFirstReason) {
  for (const DriveEnd reason : {DriveEnd::kCancelled, DriveEnd::kDisabled, DriveEnd::kObstacle}) {
    Robot robot;
    robot.drive(2.0);
    robot.driver().end(reason);
    robot.driver().end(DriveEnd::kTimeOver);
    robot.expectEnd(reason, 0.1);
  }
}

TEST(CalibrationDriver, StopsWhenConverged) {
  Robot robot;
  robot.drive(2.0);
  robot.state = CalibrationState::kConverged;
  robot.expectEnd(DriveEnd::kConverged, 0.1);
}

TEST(CalibrationDriver, StopsAtTheEndOfItsBudgets) {
  Robot in_time({DriveMotion::kDance, 3.0, 1000.0});
  in_time.expectEnd(DriveEnd::kTimeOver, 3.1);
  Robot on_path({DriveMotion::kDance, 1000.0, 0.5});
  on_path.expectEnd(DriveEnd::kPathOver, 4.0);
}

TEST(CalibrationDriver, DrivesNoWayOutOfItsRegion) {
  DriveConfig config = paperDrive();
  config.region.radius_m = 1.2;  // the first metre fits, the second side's end does not
  Robot robot(kLongDrive, config);
  robot.expectEnd(DriveEnd::kNoWay, 12.0);
  EXPECT_GT(config.region.clearance(robot.driver().startFromBase().position_m), 0.1);
}

/// After ~reset nothing is planned on what was known before, though the readings that it waits for
/// come later.
TEST(CalibrationDriver, PlansNothingOnAnEstimateThatWasTakenBack) {
  const Stamp start = stampFromSeconds(100.0);
  const auto after = [&](double time_s) { return start + durationFromSeconds(time_s); };
  CartesianEstimate light;
  light.mean << 2.0, 0.5, 0.1, 0.0, 0.0;
  light.covariance = 1e-4 * Matrix5::Identity();
  const DriveGoal goal{DriveMotion::kOptimal, 1000.0, 1000.0};
  for (const bool is_taken_back : {false, true}) {
    CalibrationDriver driver(paperDrive(), goal, start);
    driver.addTravel({start, 0.0, 0.0, 0.0}, start);
    driver.addEstimate({after(0.1), CalibrationState::kConverging, StateEstimate::of(light)},
                       after(0.05));
    if (is_taken_back) {
      driver.addEstimate({start, CalibrationState::kInitialising, std::nullopt}, after(0.06));
    }
    driver.addTravel({after(0.2), 0.0, 0.0, 0.0}, after(0.2));
    driver.steer(after(0.2));
    EXPECT_NE(driver.plan().has_value(), is_taken_back);
  }
}

/// A script without a part of it would be another one: it ends where the light forbids to go on.
TEST(CalibrationDriver, EndsAScriptThatLeadsIntoALight) {
  const Eigen::Vector2d ahead_m(0.6, 0.1), aside_m(0.0, 2.0);
  for (const auto& [first_m, second_m] : {std::pair(ahead_m, aside_m), {aside_m, ahead_m}}) {
    Robot robot;
    robot.drive(2.0);
    ASSERT_FALSE(robot.driver().standing());
    CartesianEstimate estimate;
    estimate.mean << first_m, 0.05, 0.0, 0.0;
    estimate.covariance = 1e-4 * Matrix5::Identity();
    robot.estimate =
        withLight(StateEstimate::of(estimate), second_m, 1e-4 * Eigen::Matrix2d::Identity());
    robot.expectEnd(DriveEnd::kNoWay, 0.1);
  }
}

/// Time stands still, but the robot does not.
TEST(CalibrationDriver, BrakesByRealTimeWhereItsOwnStandsStill) {
  Robot robot;
  robot.drive(1.0);
  CalibrationDriver& driver = robot.driver();
  const Stamp still = stampFromSeconds(101.0);
  const double speed_mps = driver.command().right_mps;
  ASSERT_GT(speed_mps, 0.1);
  driver.end(DriveEnd::kCancelled);
  EXPECT_NEAR(driver.steer(still, kPeriod_s).right_mps, speed_mps - kAcceleration * kPeriod_s,
              1e-9);
  for (int i = 0; i < 3; ++i) driver.steer(still, kPeriod_s);
  EXPECT_TRUE(driver.standing());
}

/// Somebody pushes it on where the first metre ends: it is the border itself that stops it.
TEST(CalibrationDriver, StopsOutsideOfItsRegion) {
  DriveConfig config = paperDrive();
  config.region.radius_m = 1.12;
  CalibrationDriver driver(config, kLongDrive, stampFromSeconds(1.0));
  Stamp now = stampFromSeconds(1.0);
  for (double pushed_m = 0.0; pushed_m < 1.3; pushed_m += 0.0625) {
    now += durationFromSeconds(kPeriod_s);
    driver.addTravel({now, pushed_m, pushed_m, 0.0}, now);
    driver.addBearings({now, {Bearing()}}, now);
    driver.addEstimate({now, CalibrationState::kInitialising, std::nullopt}, now);
    driver.steer(now);
  }
  EXPECT_STREQ(nameOf(driver.ended()), "LEFT_REGION");
}

TEST(CalibrationDriver, StopsWhenTheWheelsDoNotRoll) {
  Robot robot;
  robot.wheels_roll = false;
  robot.expectEnd(DriveEnd::kWheelsDisobeyed, 3.5);
}

TEST(CalibrationDriver, NamesWhatIsWrongWithItsConfiguration) {
  DriveConfig config = paperDrive();
  config.limits.max_speed_mps = 0.0;
  config.timeouts.ticks_s = std::nan("");
  EXPECT_EQ(errorsOf(config).size(), 2u);
  EXPECT_THROW(CalibrationDriver(config, kLongDrive, Stamp()), std::invalid_argument);
  EXPECT_THROW(CalibrationDriver(paperDrive(), {DriveMotion::kDance, 0.0, 1.0}, Stamp()),
               std::invalid_argument);
}

/// The table of driving.md on a sample that a build can afford; drive_table runs it in full.
TEST(CalibrationDriver, TeachesMoreThanThePapersDance) {
  const auto summaryOf = [](const DrivenMotion& motion) {
    std::vector<DriveRecord> records;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      records.push_back(drive(motionCase(motion, seed, 100.0)));
    }
    return summarise(records);
  };
  const MotionSummaryRow planned = summaryOf(comparedMotions()[0]);
  const std::vector<Bar> bars = judgeBars(planned);
  EXPECT_TRUE(allReached(bars)) << format(bars);
  const MotionSummaryRow dance = summaryOf(comparedMotions()[1]);
  EXPECT_NEAR(dance.figure, 0.745, 0.06);  // the bound along it, without ramps (driving.md)
  EXPECT_LT(3.0 * planned.figure, dance.figure);
}

TEST(CalibrationDriver, ConvergesFromNothing) {
  std::vector<DriveRecord> records;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) records.push_back(drive(roomCase(seed)));
  const std::vector<Bar> bars = judgeBars(summariseRooms(records));
  EXPECT_TRUE(allReached(bars)) << format(bars);
}

/// The table of driving.md on a sample.
TEST(CalibrationDriver, ConvergesWithALimitedFieldOfView) {
  for (const double width_deg : {60.0, 90.0, 180.0}) {
    std::vector<DriveRecord> records;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      records.push_back(drive(viewCase(seed, radiansFromDegrees(width_deg), true)));
    }
    const std::vector<Bar> bars = judgeBars(summariseRooms(records));
    EXPECT_TRUE(allReached(bars)) << width_deg << '\n' << format(bars);
  }
}

/// In these rooms a planner that trusted the wheels stayed where the light's own uncertainty put
/// it.
TEST(CalibrationDriver, ComesNearAFarLight) {
  for (const std::uint64_t seed : {4U, 61U, 95U}) {
    const DriveRecord record = drive(farRoomCase(seed));
    EXPECT_EQ(record.end, DriveEnd::kConverged) << seed << ": " << describe(record.end);
    EXPECT_GT(record.least_kept_distance_m, kNear_m) << seed;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
