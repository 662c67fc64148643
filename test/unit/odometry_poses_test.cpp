// Wheel travel out of the poses of nav_msgs/Odometry.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/wheel_odometer.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSeparation = 0.25;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Stamp at(double seconds) { return stampFromSeconds(100.0 + seconds); }

/// No odometry has anything to do with radii and ticks: the largest that there are.
DriveGeometry geometry() { return {kSeparation, 10.0, 10.0, 0.1, 8, 1.0}; }

OdometryPose poseAt(double time_s, double x_m, double y_m, double yaw_rad) {
  OdometryPose pose;
  pose.stamp = at(time_s);
  pose.start_from_base = {{x_m, y_m}, wrapAngle(yaw_rad)};
  pose.frames = "odom, base_link";
  return pose;
}

/// How a driver goes on by one step: by the heading at its beginning (0), middle (0.5) or end (1).
void integrate(double left_m, double right_m, double heading_at, OdometryPose* pose) {
  const double turn = (right_m - left_m) / kSeparation;
  const double way_m = 0.5 * (left_m + right_m);
  double& yaw_rad = pose->start_from_base.yaw_rad;
  const double heading = yaw_rad + heading_at * turn;
  pose->start_from_base.position_m += way_m * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  yaw_rad = wrapAngle(yaw_rad + turn);
}

TEST(WheelsFromArc, AreThoseThatMadeTheArc) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> way(-1.0, 1.0);
  std::uniform_real_distribution<double> turn(-3.1, 3.1);
  for (int i = 0; i < 200; ++i) {
    const double half = 0.5 * kSeparation * (i == 0 ? 0.0 : turn(random));
    const double middle = way(random);
    const WheelDisplacement wheels = wheelsFromArc(
        arcFromWheels({middle - half, middle + half}, kSeparation).start_from_end, kSeparation);
    EXPECT_NEAR(wheels.left_m, middle - half, 1e-12);
    EXPECT_NEAR(wheels.right_m, middle + half, 1e-12);
  }
}

// On a circle of radius r about (0, r) the base is at r (sin a, 1 - cos a), a = distance / r.
TEST(OdometryPoses, GiveTheTravelOnACircle) {
  constexpr double kRadius = 0.7;
  constexpr double kSpeed = 0.4;
  WheelOdometer odometer(geometry());
  for (int i = 0; i <= 1000; ++i) {  // nine turns: the heading wraps
    const double time_s = 0.1 * i;
    const double angle = kSpeed * time_s / kRadius;
    const InputOutcome outcome = odometer.add(
        poseAt(time_s, kRadius * std::sin(angle), kRadius * (1.0 - std::cos(angle)), angle));
    ASSERT_TRUE(outcome.accepted()) << describe(outcome) << ", reading " << i;
  }
  const double turn = kSpeed * 100.0 / kRadius;
  EXPECT_NEAR(odometer.travel()->left_m, turn * (kRadius - 0.5 * kSeparation), 1e-9);
  EXPECT_NEAR(odometer.travel()->right_m, turn * (kRadius + 0.5 * kSeparation), 1e-9);
  EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
}

// A step of length s and turn w that a driver takes along its heading at one end is a chord; the
// arc that is made of it is longer or shorter by less than the share w^2 / 6.
TEST(OdometryPoses, OfAnyIntegrationAreAccepted) {
  constexpr double kMost_m = 0.04;  // of a wheel in one step: a turn of at most 0.32
  for (const double heading_at : {0.0, 0.5, 1.0}) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> speed(-kMost_m, kMost_m);
    WheelOdometer odometer(geometry());
    OdometryPose pose = poseAt(0.0, 0.0, 0.0, 0.0);
    odometer.add(pose);
    double left_m = 0.0, right_m = 0.0, way_m = 0.0;
    for (int i = 1; i <= 500; ++i) {
      const double left = speed(random), right = speed(random);
      for (int step = 0; step < 20; ++step) {  // steady for a second
        integrate(left, right, heading_at, &pose);
        pose.stamp += durationFromSeconds(0.05);
        const InputOutcome outcome = odometer.add(pose);
        ASSERT_TRUE(outcome.accepted()) << describe(outcome) << ", heading at " << heading_at;
        left_m += left;
        right_m += right;
        way_m += std::abs(0.5 * (left + right));
      }
    }
    constexpr double kShare = 0.32 * 0.32 / 6.0;
    EXPECT_NEAR(odometer.travel()->left_m, left_m, kShare * way_m);
    EXPECT_NEAR(odometer.travel()->right_m, right_m, kShare * way_m);
    EXPECT_NEAR(odometer.travel()->right_m - odometer.travel()->left_m, right_m - left_m, 1e-9);
  }
}

TEST(OdometryPoses, InWholeMillimetresAreAccepted) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> speed(-0.01, 0.01);
  WheelOdometer odometer(geometry());
  OdometryPose pose = poseAt(0.0, 0.0, 0.0, 0.0);
  for (int i = 0; i < 500; ++i) {
    const double left = speed(random), right = speed(random);
    for (int step = 0; step < 50; ++step) {
      integrate(left, right, 0.5, &pose);
      pose.stamp += durationFromSeconds(0.02);
      OdometryPose rounded = pose;
      for (double& number : rounded.start_from_base.position_m) {
        number = 1e-3 * std::round(1e3 * number);
      }
      rounded.start_from_base.yaw_rad =
          kPi / 2048.0 * std::round(pose.start_from_base.yaw_rad / (kPi / 2048.0));
      const InputOutcome outcome = odometer.add(rounded);
      ASSERT_TRUE(outcome.accepted()) << describe(outcome);
    }
  }
  EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
}

/// What `make` gives at 50 Hz for three seconds, after a second straight ahead.
template <class Make>
int countSideways(Make make) {
  WheelOdometer odometer(geometry());
  for (int i = -50; i < 0; ++i) odometer.add(poseAt(0.02 * i, 0.01 * i, 0.0, 0.0));
  int refused = 0;
  for (int i = 0; i < 150; ++i) {
    if (odometer.add(make(0.02 * i)).status == InputStatus::kMovedSideways) ++refused;
  }
  return refused;
}

TEST(OdometryPoses, ThatMoveSidewaysAreRefused) {
  EXPECT_EQ(countSideways([](double t) { return poseAt(t, 0.5 * t, 0.0, 0.0); }), 0);
  EXPECT_GT(countSideways([](double t) { return poseAt(t, 0.0, 0.3 * t, 0.0); }), 30)
      << "holonomic";
  EXPECT_GT(countSideways([](double t) { return poseAt(t, 0.5 * t, 0.02 * t, 0.0); }), 3) << "slow";
  // a frame 0.1 m ahead of the axle, about which the robot turns
  EXPECT_GT(countSideways([](double t) {
              return poseAt(t, 0.1 * std::cos(0.5 * t) - 0.1, 0.1 * std::sin(0.5 * t), 0.5 * t);
            }),
            10);
}

TEST(OdometryPoses, FollowACorrectionThatPersists) {
  WheelOdometer odometer(geometry());
  odometer.add(poseAt(0.0, 5.0, 5.0, 0.0));
  EXPECT_TRUE(odometer.add(poseAt(0.1, 5.05, 5.0, 0.0)).accepted());
  const InputOutcome sideways = odometer.add(poseAt(0.2, 5.10, 5.02, 0.0));
  EXPECT_EQ(sideways.status, InputStatus::kMovedSideways);
  EXPECT_NEAR(sideways.value, 0.02, 1e-9);
  EXPECT_EQ(odometer.add(poseAt(0.3, 5.15, 5.02, 0.0)).status, InputStatus::kCounterReset);
  EXPECT_TRUE(odometer.add(poseAt(0.4, 5.20, 5.02, 0.0)).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 0.10, 1e-9);
  // 0.2 s and the stamps' 10 ms at 1 m/s, and 2 mm
  EXPECT_NEAR(odometer.travel()->unseen_variance_m2, 0.212 * 0.212 / 3.0, 1e-9);
}

TEST(OdometryPoses, ThatJumpAreRefusedAndAResetIsFollowed) {
  WheelOdometer odometer(geometry());
  odometer.add(poseAt(0.0, 5.0, 3.0, 1.0));
  EXPECT_EQ(odometer.add(poseAt(0.1, 9.0, 3.0, 1.0)).status, InputStatus::kTicksTooFast);
  EXPECT_TRUE(odometer.add(poseAt(0.2, 5.0, 3.0, 1.0)).accepted());
  EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
  EXPECT_EQ(odometer.add(poseAt(0.3, 0.01, 0.0, 0.0)).status, InputStatus::kCounterReset);
  EXPECT_EQ(odometer.travel()->left_m, 0.0);
  EXPECT_NEAR(odometer.travel()->unseen_variance_m2, 0.112 * 0.112 / 3.0, 1e-9);
  EXPECT_EQ(odometer.add(poseAt(0.4, 0.0, 3.0, 0.0)).status, InputStatus::kMovedSideways)
      << "straight beside the origin is no reset";
}

TEST(OdometryPoses, ThatAreNoPosesAreRefused) {
  WheelOdometer odometer(geometry());
  EXPECT_TRUE(odometer.add(poseAt(0.0, 1.0, 0.0, 0.0)).accepted());
  EXPECT_EQ(odometer.add(poseAt(0.1, kNaN, 0.0, 0.0)).status, InputStatus::kPoseNotFinite);
  EXPECT_EQ(odometer.add(poseAt(0.1, 1.0, INFINITY, 0.0)).status, InputStatus::kPoseNotFinite);
  EXPECT_EQ(odometer.add(poseAt(0.1, 1.0, 0.0, kNaN)).status, InputStatus::kPoseNotFinite);
  for (const double norm : {0.0, 0.9, 2.0, kNaN}) {
    OdometryPose pose = poseAt(0.1, 1.0, 0.0, 0.0);
    pose.quaternion_norm = norm;
    EXPECT_EQ(odometer.add(pose).status, InputStatus::kQuaternionNotUnit) << norm;
  }
  OdometryPose other = poseAt(0.1, 1.0, 0.0, 0.0);
  other.frames = "map, base_link";
  EXPECT_EQ(odometer.add(other).status, InputStatus::kFramesChanged);
  EXPECT_EQ(odometer.add(poseAt(0.0, 1.0, 0.0, 0.0)).status, InputStatus::kStampNotAfterLast);
  EXPECT_EQ(odometer.travel()->stamp, at(0.0));
  EXPECT_TRUE(odometer.add(poseAt(0.1, 1.05, 0.0, 0.0)).accepted());
}

TEST(OdometryPoses, LoseNoMotionWhenTheClockStepsBack) {
  WheelOdometer odometer(geometry());
  int refused = 0;
  for (int i = 0; i <= 400; ++i) {
    const double time_s = 0.02 * i;
    const InputOutcome outcome =
        odometer.add(poseAt(i < 200 ? time_s : time_s - 0.3, 0.9 * time_s, 0.0, 0.0));
    refused += outcome.status == InputStatus::kStampNotAfterLast ? 1 : 0;
    ASSERT_TRUE(outcome.accepted() || outcome.status == InputStatus::kStampNotAfterLast);
  }
  EXPECT_EQ(refused, 15);
  EXPECT_NEAR(odometer.travel()->left_m, 0.9 * 8.0, 1e-9);
  EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
}

TEST(OdometryPoses, SayWhenAGapMayHideATurn) {
  for (const double yaw_rad : {0.0, 1.5, -2.0, 3.1}) {  // whatever way the robot heads
    const auto ahead = [yaw_rad](double time_s, double way_m) {
      return poseAt(time_s, way_m * std::cos(yaw_rad), way_m * std::sin(yaw_rad), yaw_rad);
    };
    WheelOdometer odometer(geometry());  // a turn takes pi 0.25 m / 1 m/s = 0.785 s at the fastest
    odometer.add(ahead(0.0, 0.0));
    EXPECT_TRUE(odometer.add(ahead(0.75, 0.3)).accepted()) << yaw_rad;
    EXPECT_EQ(odometer.add(ahead(1.6, 0.6)).status, InputStatus::kTicksGap) << yaw_rad;
    EXPECT_NEAR(odometer.travel()->left_m, 0.3, 1e-9);
  }
}

TEST(OdometryPoses, ThatStandWhileTheTwistMovesAreRefused) {
  for (const auto& [forward_mps, turn_radps] : {std::pair(0.2, 0.0), std::pair(0.0, -1.6)}) {
    WheelOdometer odometer(geometry());  // either way a wheel does 0.2 m/s: 0.2 m in a second
    InputOutcome outcome;
    int accepted = 0;
    for (int i = 0; i < 100; ++i) {
      OdometryPose pose = poseAt(0.02 * i, 0.0, 0.0, 0.0);
      pose.forward_mps = forward_mps;
      pose.turn_radps = turn_radps;
      outcome = odometer.add(pose);
      accepted += outcome.accepted() ? 1 : 0;
    }
    EXPECT_EQ(outcome.status, InputStatus::kTwistWithoutPose);
    EXPECT_NEAR(accepted, 51, 1);
    OdometryPose moved = poseAt(2.01, 0.01, 0.0, 0.0);
    moved.forward_mps = forward_mps;
    EXPECT_NE(odometer.add(moved).status, InputStatus::kTwistWithoutPose);
  }
}

// A gyroscope's bias of 2 degrees a second, and encoders whose speeds flicker: for minutes.
TEST(OdometryPoses, ThatStandAreAcceptedWhateverNoiseTheTwistHas) {
  WheelOdometer odometer(geometry());
  std::mt19937_64 random(13);
  std::normal_distribution<double> flicker(0.0, 0.002);
  for (int i = 0; i < 15000; ++i) {
    OdometryPose pose = poseAt(0.02 * i, 0.0, 0.0, 0.0);
    pose.forward_mps = flicker(random);
    pose.turn_radps = 0.035;
    const InputOutcome outcome = odometer.add(pose);
    ASSERT_TRUE(outcome.accepted()) << describe(outcome) << ", reading " << i;
  }
  EXPECT_TRUE(odometer.add(poseAt(300.0, 0.01, 0.0, 0.0)).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 0.01, 1e-9);
}

TEST(OdometryPoses, NeedNoTwist) {
  for (const double nothing : {0.0, kNaN}) {
    WheelOdometer odometer(geometry());
    for (int i = 0; i < 500; ++i) {
      OdometryPose pose = poseAt(0.02 * i, 0.005 * std::max(0, i - 300), 0.0, 0.0);
      pose.forward_mps = pose.turn_radps = nothing;
      ASSERT_TRUE(odometer.add(pose).accepted());
    }
  }
}

}  // namespace
}  // namespace bearing_calibration::core
