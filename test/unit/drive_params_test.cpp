// The drive node's parameters as they are shipped, and what is said of wrong ones.

#include "bearing_calibration_ros/drive_params.h"

#include <bearing_calibration/CalibrationDriveResult.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "bearing_calibration_ros/drive_publisher.h"
#include "bearing_calibration_ros/drive_wheels.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/safety_input.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

const std::string kConfigFolder = BEARING_CALIBRATION_CONFIG_FOLDER;

DriveNodeConfig readWith(const std::string& changes) {
  const std::string file = testing::TempDir() + "drive_params_changes.yaml";
  std::ofstream(file) << changes;
  return readConfig<DriveNodeConfig>(ParamReader(parametersFromFiles(
      {kConfigFolder + "/calibration.yaml", kConfigFolder + "/robots/simulated.yaml",
       kConfigFolder + "/drive.yaml", file})));
}

std::string errorsWith(const std::string& changes) {
  try {
    readWith(changes);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST(DriveParams, AreReadAsShipped) {
  const DriveNodeConfig config = readWith("drive: {motion: optimal}");
  EXPECT_EQ(config.drive.limits.wheel_separation_m, 0.25);  // of robots/simulated.yaml
  EXPECT_EQ(config.drive.limits.max_speed_mps, 0.2);
  EXPECT_EQ(config.drive.sensing.wheel_noise.independent_k_m, 1e-6);  // of calibration.yaml
  EXPECT_EQ(config.drive.min_probability, 0.1);
  EXPECT_EQ(config.drive.planner.block, core::PlannerConfig::Block::kMount);
  EXPECT_TRUE(config.drive.region.polygon_m.empty());
  EXPECT_EQ(config.default_goal.motion, core::DriveMotion::kOptimal);
}

TEST(DriveEnd, HasTheNumbersOfTheMessage) {
  using Result = bearing_calibration::CalibrationDriveResult;
  struct Constant {
    core::DriveEnd end;
    int number;
    const char* name;
  };
  const std::vector<Constant> constants = {
      {core::DriveEnd::kConverged, +Result::CONVERGED, "CONVERGED"},
      {core::DriveEnd::kCancelled, +Result::CANCELLED, "CANCELLED"},
      {core::DriveEnd::kDisabled, +Result::DISABLED, "DISABLED"},
      {core::DriveEnd::kObstacle, +Result::OBSTACLE, "OBSTACLE"},
      {core::DriveEnd::kTicksLost, +Result::TICKS_LOST, "TICKS_LOST"},
      {core::DriveEnd::kLightLost, +Result::LIGHT_LOST, "LIGHT_LOST"},
      {core::DriveEnd::kEstimateLost, +Result::ESTIMATE_LOST, "ESTIMATE_LOST"},
      {core::DriveEnd::kClockLost, +Result::CLOCK_LOST, "CLOCK_LOST"},
      {core::DriveEnd::kLeftRegion, +Result::LEFT_REGION, "LEFT_REGION"},
      {core::DriveEnd::kNoWay, +Result::NO_WAY, "NO_WAY"},
      {core::DriveEnd::kWheelsDisobeyed, +Result::WHEELS_DISOBEYED, "WHEELS_DISOBEYED"},
      {core::DriveEnd::kTimeOver, +Result::TIME_OVER, "TIME_OVER"},
      {core::DriveEnd::kPathOver, +Result::PATH_OVER, "PATH_OVER"},
      {core::DriveEnd::kShutDown, +Result::SHUT_DOWN, "SHUT_DOWN"},
      {core::DriveEnd::kEnableLost, +Result::ENABLE_LOST, "ENABLE_LOST"},
      {core::DriveEnd::kObstacleLost, +Result::OBSTACLE_LOST, "OBSTACLE_LOST"},
      {core::DriveEnd::kFailed, +Result::FAILED, "FAILED"},
  };
  for (const Constant& constant : constants) {
    EXPECT_EQ(static_cast<int>(constant.end), constant.number) << constant.name;
    EXPECT_STREQ(core::nameOf(constant.end), constant.name);
  }
}

TEST(DriveParams, AllErrorsComeAtOnce) {
  const std::string errors = errorsWith(
      "limits: {wheel_speed: -0.1, wheel_speeed: 1.0}\n"
      "planner: {block: pose}\n"
      "region: {polygon: [[1, 1], [2, 1], [2, 2]]}\n"
      "timeouts: {ticks: soon}\n");
  for (const char* part :
       {"limits/wheel_speed must lie in [0.0001, 100], but is -0.1",
        "limits/wheel_speeed is not known", "planner/block must be one of (mount, position, yaw)",
        "must contain the start", "timeouts/ticks must be a finite number"}) {
    EXPECT_NE(errors.find(part), std::string::npos) << part << " is not in:\n" << errors;
  }
}

TEST(DriveParams, WheelsFasterThanBelievedAreRefused) {
  EXPECT_NE(errorsWith("limits: {wheel_speed: 3.0}").find("wheels/max_speed"), std::string::npos);
}

TEST(DriveParams, AFrameThatTfWouldNotFindIsRefused) {
  for (const char* frame : {"/drive_start", "drive start", "''"}) {
    EXPECT_NE(
        errorsWith(std::string("drive: {start_frame: ") + frame + "}").find("start_frame must"),
        std::string::npos)
        << frame;
  }
}

TEST(DriveParams, OfAnUnreadSpeedOfTheWheelsNothingElseIsSaid) {
  EXPECT_EQ(errorsWith("wheels: {max_speed: fast}"),
            "1 wrong parameter(s):\n"
            "  - parameter wheels/max_speed must be a finite number, but is the string 'fast'");
}

TEST(DriveParams, TheLastStopIsWaitedForAsLongAsItTakesWithinWhatRoslaunchWaits) {
  const auto wait_s = [](double speed_mps, double acceleration_mps2) {
    DriveNodeConfig config;
    config.drive.limits = {0.25, speed_mps, acceleration_mps2};
    return config.longestStop().toSec();
  };
  EXPECT_NEAR(wait_s(0.2, 1.0), 1.2, 1e-6);
  EXPECT_NEAR(wait_s(0.6, 0.2), 4.0, 1e-6);
  EXPECT_NEAR(wait_s(10.0, 0.1), 10.0, 1e-6);
}

// Promise stands: commands of a control loop after the shutdown hook
TEST(CommandGate, ClosedItLetsNothingPassButStanding) {
  std::vector<double> passed;
  CommandGate gate([&](const geometry_msgs::Twist& twist) { passed.push_back(twist.linear.x); });
  geometry_msgs::Twist moving;
  moving.linear.x = 0.1;
  gate.pass(moving);
  EXPECT_FALSE(gate.isClosed());
  gate.close();
  EXPECT_TRUE(gate.isClosed());
  gate.pass(moving);
  EXPECT_EQ(passed, (std::vector<double>{0.1, 0.0}));
}

TEST(DriveReports, BeforeAnEstimateItsDeviationsAreNotANumber) {
  const DriveNodeConfig config = readWith("drive: {motion: optimal}");
  const core::CalibrationDriver driver(config.drive, config.default_goal,
                                       core::stampFromSeconds(1.0));
  const auto result = resultFrom(driver, noEstimate());
  for (const double stddev : {result.x_stddev_m, result.y_stddev_m, result.yaw_stddev_rad}) {
    EXPECT_TRUE(std::isnan(stddev)) << stddev;
  }
  const auto feedback = feedbackFrom(driver, noEstimate());
  EXPECT_TRUE(std::isnan(feedback.x_stddev_m) && std::isnan(feedback.light_distance_m));
  EXPECT_EQ(feedback.state_text.find("no estimate"), 0U) << feedback.state_text;
}

/// What no bearing tells is not expected of any.
TEST(DriveEstimate, SaysApartWhatNearnessLeavesOpen) {
  constexpr double kNearness_m = 0.005;
  core::CalibrationResult result;
  EXPECT_EQ(driveEstimateFrom(messageFromResult(result, 0, "")).nearness_stddev_m, 0.0);
  result.error_priors.nearness_stddev_m = kNearness_m;
  core::StateEstimate estimate = core::StateEstimate::zero({core::kWheelErrors, 1});
  estimate.covariance.diagonal().setConstant(1e-6);
  sayEstimate(estimate, &result);
  const msg::CalibrationEstimate message = messageFromResult(result, 0, "base_link");
  EXPECT_DOUBLE_EQ(message.covariance_x_y_yaw[0], 1e-6 + kNearness_m * kNearness_m);
  const core::DriveEstimate told = driveEstimateFrom(message);
  EXPECT_LT((told.robot->covariance - estimate.covariance).norm(), 1e-15);
  EXPECT_NEAR(told.nearness_stddev_m, kNearness_m, 1e-9);
}

/// The travels of a second at 100 Hz, in which both wheels roll a turn.
template <typename Add>
bool addSecond(double start_s, const Add& add) {
  bool have_begun_anew = false;
  for (int i = 0; i < 100; ++i) {
    have_begun_anew |= add(core::stampFromSeconds(start_s + 0.01 * i), 655 * i);
  }
  return have_begun_anew;
}

TEST(DriveWheels, AreFollowedAnewOnceTheirStampsHaveBegunAnew) {
  int travels = 0;
  DriveWheels wheels(readWith("drive: {motion: optimal}"),
                     [&](const core::WheelTravel&) { ++travels; });
  const auto both = [&](core::Stamp stamp, std::int64_t ticks) {
    return wheels.add(core::WheelCounts{stamp, ticks, ticks});
  };
  const auto separate = [&](core::Stamp stamp, std::int64_t ticks) {
    const bool right_tells = wheels.add(core::WheelSide::kRight, {stamp, ticks});
    EXPECT_FALSE(right_tells);
    return wheels.add(core::WheelSide::kLeft, {stamp, ticks});
  };
  const auto expectAnew = [&](const auto& add) {
    travels = 0;
    wheels.restart();
    EXPECT_FALSE(addSecond(1000.0, add));
    EXPECT_EQ(travels, 100);
    EXPECT_TRUE(addSecond(10.0, add));
    EXPECT_EQ(travels, 100) << "a drive must miss them";
    wheels.restart();
    EXPECT_FALSE(addSecond(20.0, add));
    EXPECT_EQ(travels, 200);
  };
  expectAnew(both);
  expectAnew(separate);
}

TEST(SafetyInput, ObjectsToANoAndToSilence) {
  using core::DriveEnd;
  const SafetyInput::Ends ends{DriveEnd::kDisabled, DriveEnd::kEnableLost};
  const ros::SteadyTime began(100.0);
  const ros::WallDuration second(1.0);
  SafetyInput input(ends, 0.5, false);
  EXPECT_EQ(input.objection(began), DriveEnd::kNone);  // nobody publishes it
  input.hear(false, began);
  EXPECT_EQ(input.objection(began), DriveEnd::kDisabled);
  input.hear(true, began);
  EXPECT_EQ(input.objection(began), DriveEnd::kNone);
  EXPECT_EQ(input.objection(began + second), DriveEnd::kEnableLost);
  input.hear(true, began + second);
  EXPECT_EQ(input.objection(began + second), DriveEnd::kNone);

  SafetyInput on_change(ends, 0.0, false);
  on_change.hear(true, began);
  EXPECT_EQ(on_change.objection(began + second * 1e6), DriveEnd::kNone);
  on_change.hear(false, began);
  EXPECT_EQ(on_change.objection(began), DriveEnd::kDisabled);
}

TEST(SafetyInput, APublisherHasToSpeak) {
  using core::DriveEnd;
  const SafetyInput::Ends ends{DriveEnd::kObstacle, DriveEnd::kObstacleLost};
  const ros::SteadyTime began(100.0);
  SafetyInput dumb(ends, 0.5, false);
  dumb.seePublisher(began);
  EXPECT_EQ(dumb.objection(began), DriveEnd::kNone);
  EXPECT_EQ(dumb.objection(began + ros::WallDuration(0.6)), DriveEnd::kObstacleLost);

  SafetyInput required(ends, 0.5, true);
  EXPECT_EQ(required.objection(began), DriveEnd::kObstacleLost);
  required.seePublisher(began);
  EXPECT_EQ(required.objection(began), DriveEnd::kObstacleLost);
  required.hear(true, began);
  EXPECT_EQ(required.objection(began), DriveEnd::kNone);
}

TEST(DriveGoal, TakesTheDefaultsForWhatIsNotNamed) {
  const core::DriveGoal defaults{core::DriveMotion::kDance, 100.0, 20.0};
  const core::DriveGoal same = goalFrom("", 0.0, 0.0, defaults);
  EXPECT_EQ(same.motion, core::DriveMotion::kDance);
  EXPECT_EQ(same.max_time_s, 100.0);
  const core::DriveGoal other = goalFrom("corner_light", 5.0, 2.0, defaults);
  EXPECT_EQ(other.motion, core::DriveMotion::kCornerLight);
  EXPECT_EQ(other.max_time_s, 5.0);
  EXPECT_EQ(other.max_path_m, 2.0);
  EXPECT_THROW(goalFrom("waltz", 0.0, 0.0, defaults), std::invalid_argument);
  EXPECT_THROW(goalFrom("", -1.0, 0.0, defaults), std::invalid_argument);
  EXPECT_THROW(goalFrom("", 1e300, 0.0, defaults), std::invalid_argument);
  EXPECT_THROW(goalFrom("", 0.0, 1e300, defaults), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration_ros
