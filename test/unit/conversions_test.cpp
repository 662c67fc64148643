#include "bearing_calibration_ros/conversions.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include "bearing_calibration_ros/result_messages.h"
#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Stamps, AreExactBothWays) {
  const ros::Time time(1700000000, 999999999);
  EXPECT_EQ(stampFromRos(time).time_since_epoch().count(), 1700000000999999999);
  EXPECT_EQ(rosFromStamp(stampFromRos(time)), time);
  EXPECT_EQ(rosFromStamp(stampFromRos(ros::Time())), ros::Time());
  const ros::Time last(std::numeric_limits<std::uint32_t>::max(), 999999999);
  EXPECT_EQ(rosFromStamp(stampFromRos(last)), last);
}

TEST(Stamps, ThatRosCannotHoldAreRefused) {
  EXPECT_THROW(rosFromStamp(core::stampFromNanoseconds(-1)), std::invalid_argument);
  EXPECT_THROW(rosFromStamp(core::stampFromNanoseconds(4294967296000000000)),
               std::invalid_argument);
}

TEST(WheelMessages, KeepEveryBitOfTheCounters) {
  bearing_calibration::WheelTicks message;
  message.header.stamp = ros::Time(12, 34);
  message.left = std::numeric_limits<std::int64_t>::min();
  message.right = std::numeric_limits<std::int64_t>::max();
  const core::WheelCounts counts = countsFromMessage(message);
  EXPECT_EQ(counts.stamp, core::stampFromNanoseconds(12000000034));
  EXPECT_EQ(counts.left_ticks, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(counts.right_ticks, std::numeric_limits<std::int64_t>::max());
}

sensor_msgs::JointState jointState() {
  sensor_msgs::JointState message;
  message.header.stamp = ros::Time(5, 0);
  message.name = {"arm", "right", "left"};
  message.position = {0.1, 0.2, 0.3};
  return message;
}

TEST(JointStates, AreReadByName) {
  const auto angles = anglesFromMessage(jointState(), {"left", "right"});
  ASSERT_TRUE(angles.has_value());
  EXPECT_EQ(angles->stamp, core::stampFromNanoseconds(5000000000));
  EXPECT_EQ(angles->left_rad, 0.3);
  EXPECT_EQ(angles->right_rad, 0.2);
}

TEST(JointStates, PassWhatIsNotFiniteOnToTheCore) {
  sensor_msgs::JointState message = jointState();
  message.position = {0.1, kInfinity, kNaN};
  const auto angles = anglesFromMessage(message, {"left", "right"});
  ASSERT_TRUE(angles.has_value());
  EXPECT_TRUE(std::isnan(angles->left_rad));
  EXPECT_EQ(angles->right_rad, kInfinity);
}

TEST(JointStates, WithoutOneOfTheWheelsGiveNothing) {
  EXPECT_FALSE(anglesFromMessage(jointState(), {"left", "wheel"}).has_value());
  EXPECT_FALSE(anglesFromMessage(jointState(), {"wheel", "right"}).has_value());
  sensor_msgs::JointState too_short = jointState();
  too_short.position = {0.1, 0.2};  // none for "left"
  EXPECT_FALSE(anglesFromMessage(too_short, {"left", "right"}).has_value());
  EXPECT_FALSE(anglesFromMessage(sensor_msgs::JointState(), {"left", "right"}).has_value());
}

TEST(JointStates, SayWhichJointsAreThere) {
  EXPECT_EQ(describeMissing({"left", "wheel"}, jointState()),
            "joints 'left' and 'wheel' with a position each are wanted, but the message has (arm, "
            "right, left): message ignored");
  sensor_msgs::JointState without_positions = jointState();
  without_positions.position.clear();
  EXPECT_EQ(describeMissing({"left", "right"}, without_positions),
            "joints 'left' and 'right' with a position each are wanted, but the message has (arm, "
            "right, left) with 0 positions: message ignored");
  EXPECT_TRUE(namesEither(jointState(), {"left", "wheel"}));
  EXPECT_TRUE(namesEither(jointState(), {"wheel", "right"}));
  EXPECT_FALSE(namesEither(jointState(), {"wheel_l", "wheel_r"}));
}

TEST(Odometry, GivesPoseTwistAndFrames) {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(7, 8);
  message.header.frame_id = "odom";
  message.child_frame_id = "base_link";
  message.pose.pose.position.x = 3.0;
  message.pose.pose.position.y = -4.0;
  message.pose.pose.orientation.z = std::sin(0.5 * -2.5);
  message.pose.pose.orientation.w = std::cos(0.5 * -2.5);
  message.twist.twist.linear.x = 0.3;
  message.twist.twist.angular.z = -0.2;
  const core::OdometryPose pose = odometryFromMessage(message);
  EXPECT_EQ(pose.stamp, core::stampFromNanoseconds(7000000008));
  EXPECT_EQ(pose.start_from_base.position_m, Eigen::Vector2d(3.0, -4.0));
  EXPECT_NEAR(pose.start_from_base.yaw_rad, -2.5, 1e-12);
  EXPECT_NEAR(pose.quaternion_norm, 1.0, 1e-12);
  EXPECT_EQ(pose.forward_mps, 0.3);
  EXPECT_EQ(pose.turn_radps, -0.2);
  EXPECT_EQ(pose.frames, "odom, base_link");
}

// On a ramp: the heading is the direction of the base's x axis in the plane.
TEST(Odometry, TakesTheHeadingOfATiltedBase) {
  const Eigen::Quaterniond tilted = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d forward = tilted * Eigen::Vector3d::UnitX();
  nav_msgs::Odometry message;
  message.pose.pose.orientation.x = tilted.x();
  message.pose.pose.orientation.y = tilted.y();
  message.pose.pose.orientation.z = tilted.z();
  message.pose.pose.orientation.w = tilted.w();
  EXPECT_NEAR(odometryFromMessage(message).start_from_base.yaw_rad,
              std::atan2(forward.y(), forward.x()), 1e-12);
}

TEST(Odometry, PassesAWrongQuaternionOnToTheCore) {
  nav_msgs::Odometry message;  // ROS's default: all zero
  EXPECT_EQ(odometryFromMessage(message).quaternion_norm, 0.0);
  message.pose.pose.orientation.w = kNaN;
  EXPECT_TRUE(std::isnan(odometryFromMessage(message).start_from_base.yaw_rad));
}

TEST(BearingMessages, KeepEveryFieldOfEveryCandidate) {
  bearing_calibration::LightBearings message;
  message.header.stamp = ros::Time(7, 8);
  message.harmonic_stddev = 0.02;
  message.near_per_far = -0.6;
  message.nearness_stddev = kNaN;
  message.view_centre = -1.5;
  message.view_width = 0.75;
  message.candidates.resize(2);
  message.candidates[0].azimuth = kNaN;
  message.candidates[0].azimuth_variance = -kInfinity;
  bearing_calibration::LightBearing& second = message.candidates[1];
  second.azimuth = -3.0;
  second.azimuth_variance = 1e-4;
  second.image_radius = 120.5;
  second.image_radius_variance = 0.25;
  second.elevation = 0.1;
  second.elevation_variance = kNaN;
  second.light_id = 3;
  second.probability = 0.5F;
  second.track_probability = 0.25F;
  const core::BearingSet bearings = bearingsFromMessage(message);
  EXPECT_EQ(bearings.stamp, core::stampFromNanoseconds(7000000008));
  EXPECT_EQ(bearings.geometry.harmonic_stddev_rad, 0.02);
  EXPECT_EQ(bearings.geometry.near_per_far_m, -0.6);
  EXPECT_EQ(bearings.geometry.nearness_stddev_rad_m, 0.0) << "not said";
  EXPECT_EQ(bearings.view.centre_rad, -1.5);
  EXPECT_EQ(bearings.view.width_rad, 0.75);
  message.view_width = kNaN;
  EXPECT_FALSE(bearingsFromMessage(message).view.isLimited()) << "not said";
  ASSERT_EQ(bearings.candidates.size(), 2U);
  EXPECT_TRUE(std::isnan(bearings.candidates[0].azimuth_rad));
  EXPECT_EQ(bearings.candidates[0].azimuth_variance_rad2, -kInfinity);
  const core::Bearing& bearing = bearings.candidates[1];
  EXPECT_EQ(bearing.azimuth_rad, -3.0);
  EXPECT_EQ(bearing.azimuth_variance_rad2, 1e-4);
  EXPECT_EQ(bearing.image_radius_px, 120.5);
  EXPECT_EQ(bearing.image_radius_variance_px2, 0.25);
  EXPECT_EQ(bearing.elevation_rad, 0.1);
  EXPECT_TRUE(std::isnan(bearing.elevation_variance_rad2));
  EXPECT_EQ(bearing.light_id, 3);
  EXPECT_EQ(bearing.probability, 0.5);
  EXPECT_EQ(bearing.track_probability, 0.25);
}

TEST(BearingMessages, SayWhatTheSensorSees) {
  core::BearingSet set;
  set.stamp = core::stampFromSeconds(1.0);
  EXPECT_EQ(messageFromBearings(set, "mast").view_width, 0.0);
  set.view = {0.25, 1.5};
  const bearing_calibration::LightBearings message = messageFromBearings(set, "mast");
  EXPECT_EQ(message.view_centre, 0.25);
  EXPECT_EQ(message.view_width, 1.5);
}

TEST(BearingMessages, UnknownLightIsTheSameOnBothSides) {
  EXPECT_EQ(static_cast<std::int32_t>(bearing_calibration::LightBearing::UNKNOWN_LIGHT),
            core::kUnknownLight);
}

TEST(Predictions, KeepTheirFields) {
  const bearing_calibration::PredictedBearing message = messageFromPrediction(
      {core::stampFromNanoseconds(9000000001), 1.5, 0.01, 4, 2.5, 0.04}, "camera");
  EXPECT_EQ(message.header.stamp, ros::Time(9, 1));
  EXPECT_EQ(message.header.frame_id, "camera");
  EXPECT_EQ(message.azimuth, 1.5);
  EXPECT_EQ(message.azimuth_variance, 0.01);
  EXPECT_EQ(message.light_id, 4);
  EXPECT_EQ(message.distance, 2.5);
  EXPECT_EQ(message.distance_variance, 0.04);
  const core::BearingPrediction prediction = predictionFromMessage(message);
  EXPECT_EQ(prediction.distance_m, 2.5);
  EXPECT_EQ(prediction.distance_variance_m2, 0.04);
}

TEST(Estimate, StatesHaveTheMessagesNumbers) {
  using Message = bearing_calibration::CalibrationEstimate;
  const auto number = [](core::CalibrationState state) { return static_cast<int>(state); };
  EXPECT_EQ(number(core::CalibrationState::kWaitingForTicks), +Message::WAITING_FOR_TICKS);
  EXPECT_EQ(number(core::CalibrationState::kWaitingForLight), +Message::WAITING_FOR_LIGHT);
  EXPECT_EQ(number(core::CalibrationState::kInitialising), +Message::INITIALISING);
  EXPECT_EQ(number(core::CalibrationState::kConverging), +Message::CONVERGING);
  EXPECT_EQ(number(core::CalibrationState::kConverged), +Message::CONVERGED);
  EXPECT_EQ(number(core::CalibrationState::kDegenerateMotion), +Message::DEGENERATE_MOTION);
  EXPECT_EQ(number(core::CalibrationState::kInconsistent), +Message::INCONSISTENT);
  EXPECT_EQ(number(core::CalibrationState::kPaused), +Message::PAUSED);
}

TEST(Estimate, FaultsHaveTheMessagesNumbersAndNames) {
  using Message = bearing_calibration::CalibrationEstimate;
  using core::Fault;
  core::CalibrationResult result;
  const auto expectCause = [&](Fault cause, std::uint8_t number, const std::string& name) {
    result.cause = cause;
    const Message message = messageFromResult(result, 0, "base_link");
    EXPECT_EQ(message.cause, number) << name;
    EXPECT_EQ(message.cause_text, name);
  };
  expectCause(Fault::kMirrored, Message::MIRRORED, "MIRRORED");
  expectCause(Fault::kLeftReversed, Message::LEFT_WHEEL_REVERSED, "LEFT_WHEEL_REVERSED");
  expectCause(Fault::kRightReversed, Message::RIGHT_WHEEL_REVERSED, "RIGHT_WHEEL_REVERSED");
  expectCause(Fault::kLate, Message::BEARINGS_LATE, "BEARINGS_LATE");
  expectCause(Fault::kLeftRadius, Message::LEFT_RADIUS, "LEFT_RADIUS");
  expectCause(Fault::kRightRadius, Message::RIGHT_RADIUS, "RIGHT_RADIUS");
  expectCause(Fault::kSeparation, Message::WHEEL_SEPARATION, "WHEEL_SEPARATION");
  expectCause(Fault::kLightMoved, Message::LIGHT_MOVED, "LIGHT_MOVED");
  expectCause(Fault::kMountMoved, Message::MOUNT_MOVED, "MOUNT_MOVED");
  expectCause(Fault::kLightsDisagree, Message::LIGHTS_DISAGREE, "LIGHTS_DISAGREE");
  expectCause(Fault::kPartsDisagree, Message::PARTS_DISAGREE, "PARTS_DISAGREE");
  expectCause(Fault::kScatter, Message::SCATTER, "SCATTER");
  expectCause(Fault::kUnexplained, Message::UNEXPLAINED, "UNEXPLAINED");
}

TEST(Estimate, IsNaNBeforeThereIsOne) {
  core::CalibrationResult result;
  result.advice = "no wheel readings yet";
  const bearing_calibration::CalibrationEstimate message =
      messageFromResult(result, 0, "base_link");
  EXPECT_EQ(message.header.stamp, ros::Time());
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_EQ(message.state_text, "WAITING_FOR_TICKS");
  EXPECT_EQ(message.advice, "no wheel readings yet");
  EXPECT_EQ(message.cause, +bearing_calibration::CalibrationEstimate::NO_FAULT);
  EXPECT_EQ(message.cause_text, "");
  for (double value :
       {message.x_m, message.y_m, message.yaw_rad, message.x_stddev_m, message.D_m, message.phi_rad,
        message.covariance_x_y_yaw[4], message.covariance_D_theta_phi_rho_psi[24]}) {
    EXPECT_TRUE(std::isnan(value)) << value;
  }
  EXPECT_FALSE(message.phi_psi_determined);
  EXPECT_EQ(message.rejections, "");
}

/// Every entry tells its row and column, so that none can be swapped unseen: row 1, column 2 of a
/// 3x3 matrix is 12 here.
template <int Size>
Eigen::Matrix<double, Size, Size> numberedMatrix() {
  Eigen::Matrix<double, Size, Size> matrix;
  for (int row = 0; row < Size; ++row) {
    for (int column = 0; column < Size; ++column) matrix(row, column) = 10 * row + column;
  }
  return matrix;
}

TEST(Estimate, IsWrittenRowByRow) {
  core::CalibrationResult result;
  result.stamp = core::stampFromNanoseconds(3000000004);
  result.base_from_sensor = core::MountEstimate{{1.0, 2.0, 3.0}, numberedMatrix<3>()};
  core::PaperEstimate paper;
  paper.mean << 4.0, 5.0, 6.0, 7.0, 8.0;
  paper.covariance = numberedMatrix<5>();
  paper.phi_psi_determined = true;
  result.paper_state = paper;
  const bearing_calibration::CalibrationEstimate message =
      messageFromResult(result, 0, "base_link");
  EXPECT_EQ(message.header.stamp, ros::Time(3, 4));
  EXPECT_EQ(message.x_m, 1.0);
  EXPECT_EQ(message.y_m, 2.0);
  EXPECT_EQ(message.yaw_rad, 3.0);
  EXPECT_EQ(message.y_stddev_m, std::sqrt(11.0));
  EXPECT_EQ(message.yaw_stddev_rad, std::sqrt(22.0));
  EXPECT_EQ(message.covariance_x_y_yaw[5], 12.0);
  EXPECT_EQ(message.D_m, 4.0);
  EXPECT_EQ(message.theta_rad, 5.0);
  EXPECT_EQ(message.phi_rad, 6.0);
  EXPECT_EQ(message.rho_m, 7.0);
  EXPECT_EQ(message.psi_rad, 8.0);
  EXPECT_EQ(message.covariance_D_theta_phi_rho_psi[5 * 3 + 1], 31.0);
  EXPECT_TRUE(message.phi_psi_determined);
}

TEST(Estimate, HoldsAnErrorThatIsKnownAtItsPrior) {
  core::CalibrationResult result;
  result.error_priors.setBlock(core::MirrorHarmonic::kName, 0.03);
  result.robot_errors = core::priorEstimate(result.error_priors);
  const int cosine = core::placeOf<core::MirrorHarmonic>();
  result.robot_errors.covariance.diagonal().segment<2>(cosine) *= 0.01;
  result.robot_errors.covariance(cosine + 2, cosine + 2) = 0.0;
  std::map<std::string, int> states;
  for (const auto& error : messageFromResult(result, 0, "base_link").robot_errors) {
    states[error.name] = error.state;
  }
  EXPECT_EQ(states.at("mirror_harmonic_cos"), +bearing_calibration::RobotError::ESTIMATED);
  EXPECT_EQ(states.at("mirror_near_per_far"), +bearing_calibration::RobotError::HELD_AT_PRIOR);
}

TEST(Estimate, BringsLightMountAndWheelsBack) {
  core::CalibrationResult result;
  EXPECT_FALSE(robotFromMessage(messageFromResult(result, 0, "base_link")));
  core::StateEstimate estimate = core::StateEstimate::zero({core::kWheelErrors, 1});
  estimate.mean << 3.0, 4.0, 5.0, 0.1, 1.1, 2.1, 3.1, 1.0, 2.0;
  for (int i = 0; i < 81; ++i) estimate.covariance(i / 9, i % 9) = i;
  for (int i = 0; i < core::kWheelErrors; ++i) result.error_priors.stddev(i) = 1.0;
  sayEstimate(estimate, &result);
  bearing_calibration::CalibrationEstimate message = messageFromResult(result, 0, "base_link");
  EXPECT_EQ(message.light_x_m, 1.0);
  EXPECT_EQ(message.light_y_m, 2.0);
  EXPECT_EQ(message.covariance_with_clock_and_wheels[9 * 1 + 3], 9.0 * 8 + 1);  // light y, sensor y
  const auto back = robotFromMessage(message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->mean, estimate.mean);
  EXPECT_EQ(back->covariance, estimate.covariance);
  message.covariance_with_clock_and_wheels[7] = std::nan("");
  EXPECT_FALSE(robotFromMessage(message));
}

TEST(Estimate, ListsTheLightsWhereThereAreSeveral) {
  core::CalibrationResult result;
  core::LightSummary light;
  light.light_id = 7;
  light.cartesian_state.emplace();
  light.cartesian_state->mean << 3.0, 4.0, 0.1, 0.2, 0.3;
  light.cartesian_state->covariance.topLeftCorner<2, 2>() << 1.0, 2.0, 2.0, 5.0;
  light.in_estimate = true;
  light.bearings_used = 12;
  result.lights = {light};
  EXPECT_TRUE(messageFromResult(result, 0, "base_link").lights.empty());

  result.lights.emplace_back();
  result.lights.back().note = "not found yet";
  const auto lights = messageFromResult(result, 0, "base_link").lights;
  ASSERT_EQ(lights.size(), 2U);
  EXPECT_EQ(lights[0].light_id, 7);
  EXPECT_EQ(lights[0].x_m, 3.0);
  EXPECT_EQ(lights[0].y_m, 4.0);
  EXPECT_EQ(lights[0].covariance_x_y[3], 5.0);
  EXPECT_TRUE(lights[0].in_estimate);
  EXPECT_EQ(lights[0].bearings_used, 12U);
  EXPECT_EQ(lights[1].light_id, core::kUnknownLight);
  EXPECT_TRUE(std::isnan(lights[1].x_m) && std::isnan(lights[1].covariance_x_y[0]));
  EXPECT_FALSE(lights[1].in_estimate);
  EXPECT_EQ(lights[1].note, "not found yet");
}

/// Each once, and those alone that have a place.
TEST(Estimate, BringsOtherLightsBack) {
  core::CalibrationResult result;
  core::StateEstimate estimate = core::StateEstimate::zero({core::kWheelErrors, 1});
  estimate.mean.tail<2>() << 1.0, 2.0;
  sayEstimate(estimate, &result);
  result.lights.resize(3);
  result.lights[0].cartesian_state = result.cartesian_state;
  core::CartesianEstimate& other = result.lights[1].cartesian_state.emplace();
  other.mean << 3.0, 4.0, 0.1, 0.2, 0.3;
  other.covariance.topLeftCorner<2, 2>() << 1.0, 2.0, 2.0, 5.0;
  bearing_calibration::CalibrationEstimate message = messageFromResult(result, 0, "base_link");
  const auto back = robotFromMessage(message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->layout.lights, 2);
  EXPECT_EQ(back->mean.tail<4>(), Eigen::Vector4d(1.0, 2.0, 3.0, 4.0));
  EXPECT_EQ((back->covariance.bottomRightCorner<2, 2>()), (other.covariance.topLeftCorner<2, 2>()));
  message.lights.resize(3 * core::kMostLights, message.lights[1]);
  EXPECT_EQ(robotFromMessage(message)->layout.lights, core::kMostLights);
}

TEST(Estimate, CountsBothStreamsWithTheirReasons) {
  core::CalibrationResult result;
  result.bearing_inputs[core::InputStatus::kAccepted] = 100;
  result.bearing_inputs[core::InputStatus::kIgnoredPaused] = 50;
  result.bearing_inputs[core::InputStatus::kVarianceRaised] = 7;
  result.bearing_inputs[core::InputStatus::kNoStamp] = 2;
  result.bearing_inputs[core::InputStatus::kTicksLost] = 1;
  result.tick_inputs[core::InputStatus::kCounterReset] = 4;
  const bearing_calibration::CalibrationEstimate message =
      messageFromResult(result, 8, "base_link");
  EXPECT_EQ(message.bearings_rejected, 3U);
  EXPECT_EQ(message.ticks_rejected, 12U);
  EXPECT_EQ(message.rejections,
            "ticks counter reset: 4; bearings variance raised to that of bearings/min_stddev: 7; "
            "bearings stamp is zero: 2; bearings no ticks for the bearing's stamp: 1; joint states "
            "without the wheels: 8");
}

TEST(Pose, HasTheConfiguredPartAtItsPlaces) {
  const core::MountEstimate mount{{0.1, 0.2, 0.0}, numberedMatrix<3>()};
  const core::UnestimatedMount rest{0.5, 0.03, 0.0, 0.04, 0.0, 0.05};
  const auto pose = poseFromMount(mount, rest, core::stampFromNanoseconds(1), "base_link");
  EXPECT_EQ(pose.header.stamp, ros::Time(0, 1));
  EXPECT_EQ(pose.header.frame_id, "base_link");
  EXPECT_EQ(pose.pose.pose.position.x, 0.1);
  EXPECT_EQ(pose.pose.pose.position.y, 0.2);
  EXPECT_EQ(pose.pose.pose.position.z, 0.5);
  // by hand: rows and columns are x y z roll pitch yaw; (x, y, yaw) = 0, 1, 2 in the estimate
  const double expected[36] = {0,  1,  0,           0,           0,           2,   //
                               10, 11, 0,           0,           0,           12,  //
                               0,  0,  0.03 * 0.03, 0,           0,           0,   //
                               0,  0,  0,           0.04 * 0.04, 0,           0,   //
                               0,  0,  0,           0,           0.05 * 0.05, 0,   //
                               20, 21, 0,           0,           0,           22};
  for (std::size_t i = 0; i < 36; ++i) {
    EXPECT_DOUBLE_EQ(pose.pose.covariance[i], expected[i]) << "entry " << i;
  }
}

// REP 103: yaw about z first, then pitch about the new y, then roll about the new x.
TEST(Pose, TurnsByRollPitchYaw) {
  const core::UnestimatedMount rest{0.0, 1.0, 0.1, 1.0, -0.2, 1.0};
  const auto pose = poseFromMount({{0.0, 0.0, 2.5}, Eigen::Matrix3d::Identity()}, rest,
                                  core::stampFromNanoseconds(1), "base_link");
  const Eigen::Quaterniond expected = Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  const auto& q = pose.pose.pose.orientation;
  const Eigen::Quaterniond actual(q.w, q.x, q.y, q.z);
  EXPECT_NEAR(actual.angularDistance(expected), 0.0, 1e-12);
  const auto transform = transformFromPose(pose.header, pose.pose.pose, "camera");
  EXPECT_EQ(transform.child_frame_id, "camera");
  EXPECT_EQ(transform.transform.rotation, pose.pose.pose.orientation);
}

}  // namespace
}  // namespace bearing_calibration_ros
