#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_odometer.h"
#include "support/numerical_jacobian.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSeparation = 0.25;
const WheelNoise kNoise{1e-6, 0.0};

Stamp at(double seconds) { return stampFromSeconds(100.0 + seconds); }

DriveGeometry geometry(int counter_bits) {
  DriveGeometry drive;
  drive.wheel_separation_m = kSeparation;
  drive.left_wheel_radius_m = 1.0 / (2.0 * kPi);  // one metre a revolution
  drive.right_wheel_radius_m = 1.0 / (2.0 * kPi);
  drive.ticks_per_revolution = 1000.0;  // one millimetre a tick
  drive.counter_bits = counter_bits;
  drive.max_wheel_speed_mps = 1.0;
  return drive;
}

// ---- arcs ----

TEST(Arc, QuarterTurnIsOnTheCircle) {
  constexpr double kRadius = 2.0;
  const double turn = 0.5 * kPi;
  const Arc arc = arcFromWheels(
      {turn * (kRadius - 0.5 * kSeparation), turn * (kRadius + 0.5 * kSeparation)}, kSeparation);
  EXPECT_NEAR(arc.start_from_end.position_m.x(), kRadius, 1e-12);
  EXPECT_NEAR(arc.start_from_end.position_m.y(), kRadius, 1e-12);
  EXPECT_NEAR(arc.start_from_end.yaw_rad, turn, 1e-12);
}

TEST(Arc, JacobianAgreesWithDifferences) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> displacement(-0.3, 0.3);
  std::vector<Eigen::Vector2d> wheels = {{0.0, 0.0}, {0.1, 0.1}, {0.1, 0.1 + 1e-9}, {0.1, -0.1}};
  for (int i = 0; i < 200; ++i) wheels.push_back({displacement(random), displacement(random)});
  const auto pose = [](const Eigen::Vector2d& w) {
    const Pose2 p = arcFromWheels({w.x(), w.y()}, kSeparation).start_from_end;
    return Eigen::Vector3d(p.position_m.x(), p.position_m.y(), p.yaw_rad);
  };
  for (const Eigen::Vector2d& w : wheels) {
    EXPECT_LT(testing::largestDifference(arcFromWheels({w.x(), w.y()}, kSeparation).J_pose_wheels,
                                         testing::numericalJacobian<3, 2>(pose, w, {2})),
              1e-7)
        << w.transpose();
  }
}

// Chong-Kleeman noise does not depend on how often the encoders are read: on a straight metre the
// variance of the heading is 2 K s / b^2, and of the distance K s / 2, whatever the steps.
TEST(Increment, NoiseDoesNotDependOnTheRate) {
  for (int steps : {1, 10, 1000}) {
    OdometryIncrement increment;
    for (int i = 0; i < steps; ++i) {
      increment = append(increment, {1.0 / steps, 1.0 / steps}, kSeparation, kNoise);
    }
    EXPECT_NEAR(increment.covariance(2, 2), 2e-6 / (kSeparation * kSeparation), 1e-12);
    EXPECT_NEAR(increment.covariance(0, 0), 0.5e-6, 1e-12);
    EXPECT_NEAR(increment.distance_m, 1.0, 1e-12);
  }
}

TEST(Increment, CommonNoiseIsAlongTheWay) {
  const OdometryIncrement increment = append({}, {1.0, 1.0}, kSeparation, {0.0, 4e-4});
  EXPECT_NEAR(increment.covariance(0, 0), 4e-4, 1e-15);
  EXPECT_NEAR(increment.covariance(2, 2), 0.0, 1e-15);
}

TEST(Increment, AppendingIncrementsIsAppendingTheirArcs) {
  const std::vector<WheelDisplacement> wheels = {
      {0.1, 0.12}, {-0.05, 0.08}, {0.2, 0.1}, {0.0, 0.3}};
  OdometryIncrement all;
  OdometryIncrement first;
  OdometryIncrement second;
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    all = append(all, wheels[i], kSeparation, kNoise);
    OdometryIncrement& half = i < 2 ? first : second;
    half = append(half, wheels[i], kSeparation, kNoise);
  }
  const OdometryIncrement joined = append(first, second);
  EXPECT_LT((joined.start_from_end.position_m - all.start_from_end.position_m).norm(), 1e-12);
  EXPECT_LT((joined.covariance - all.covariance).norm(), 1e-18);
  EXPECT_NEAR(joined.rotation_rad, all.rotation_rad, 1e-12);
}

// ---- counters ----

TEST(TickDifference, WrapsInBothDirectionsAtEveryWidth) {
  for (int bits : {8, 16, 32, 64}) {
    const std::int64_t top =
        bits == 64 ? INT64_MAX : static_cast<std::int64_t>((std::uint64_t{1} << (bits - 1)) - 1);
    const std::int64_t bottom = -top - 1;
    EXPECT_EQ(wrappedTickDifference(top, bottom, bits), 1) << bits;
    EXPECT_EQ(wrappedTickDifference(bottom, top, bits), -1) << bits;
    EXPECT_EQ(wrappedTickDifference(top - 2, bottom + 3, bits), 6) << bits;
  }
  EXPECT_EQ(wrappedTickDifference(65535, 0, 16), 1);  // sent as unsigned
  EXPECT_EQ(wrappedTickDifference(0, 65535, 16), -1);
}

// Any sequence of steps below half the range is recovered exactly from the wrapped counters.
// Promise unharmed: counters that wrap
TEST(WheelOdometer, RecoversTheTravelThroughWraps) {
  for (int bits : {8, 16, 32, 64}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(bits));
    std::uniform_int_distribution<int> step(-95, 100);
    WheelOdometer odometer(geometry(bits));
    const std::uint64_t mask = bits == 64 ? ~0ULL : (1ULL << bits) - 1;
    std::uint64_t left = mask - 10;  // about to wrap
    std::uint64_t right = 5;
    std::int64_t left_total = 0;
    std::int64_t right_total = 0;
    odometer.add(WheelCounts{at(0.0), static_cast<std::int64_t>(left & mask),
                             static_cast<std::int64_t>(right & mask)});
    for (int i = 1; i <= 1000; ++i) {
      const int left_step = step(random);
      const int right_step = step(random);
      left_total += left_step;
      right_total += right_step;
      left += static_cast<std::uint64_t>(left_step);
      right += static_cast<std::uint64_t>(right_step);
      const InputOutcome outcome =
          odometer.add(WheelCounts{at(0.1 * i), static_cast<std::int64_t>(left & mask),
                                   static_cast<std::int64_t>(right & mask)});
      ASSERT_TRUE(outcome.accepted()) << describe(outcome) << " at " << bits << " bits";
    }
    EXPECT_NEAR(odometer.travel()->left_m, 1e-3 * static_cast<double>(left_total), 1e-9);
    EXPECT_NEAR(odometer.travel()->right_m, 1e-3 * static_cast<double>(right_total), 1e-9);
    EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
  }
}

// Promise unharmed: counters that are reset
TEST(WheelOdometer, TellsAResetFromMotion) {
  WheelOdometer odometer(geometry(32));
  odometer.add(WheelCounts{at(0.0), 50000, 60000});
  const InputOutcome reset = odometer.add(WheelCounts{at(0.1), 3, 5});
  EXPECT_EQ(reset.status, InputStatus::kCounterReset);
  EXPECT_EQ(odometer.travel()->left_m, 0.0);
  // what moved unseen is within the fastest speed: 0.11 s (with jitter) at 1 m/s, plus 2 ticks
  EXPECT_NEAR(odometer.travel()->unseen_variance_m2, 0.112 * 0.112 / 3.0, 1e-9);
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.2), 53, 55}).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 0.05, 1e-12);
}

// The wheel with the longer ticks may have rolled farther than its readings say.
TEST(WheelOdometer, WhatMovesUnseenIsWithinTwoOfTheLongerTicks) {
  DriveGeometry drive = geometry(32);
  drive.left_wheel_radius_m *= 10.0;  // 10 mm a tick, and 1 mm of the right one
  WheelOdometer odometer(drive);
  odometer.add(WheelCounts{at(0.0), 50000, 60000});
  EXPECT_EQ(odometer.add(WheelCounts{at(0.1), 3, 5}).status, InputStatus::kCounterReset);
  const double reach_m = 1.0 * (0.1 + 0.01) + 2.0 * 0.01;  // speed, jitter, two ticks
  EXPECT_NEAR(odometer.travel()->unseen_variance_m2, reach_m * reach_m / 3.0, 1e-9);
}

TEST(WheelOdometer, LeavesOutASingleWrongReading) {
  WheelOdometer odometer(geometry(32));
  odometer.add(WheelCounts{at(0.0), 50000, 50000});
  EXPECT_EQ(odometer.add(WheelCounts{at(0.1), 90000, 50010}).status, InputStatus::kTicksTooFast);
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.2), 50020, 50020}).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 0.02, 1e-12);
  EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
}

TEST(WheelOdometer, FollowsAJumpThatPersists) {
  WheelOdometer odometer(geometry(32));
  odometer.add(WheelCounts{at(0.0), 50000, 50000});
  EXPECT_EQ(odometer.add(WheelCounts{at(0.1), 90000, 90000}).status, InputStatus::kTicksTooFast);
  EXPECT_EQ(odometer.add(WheelCounts{at(0.2), 90010, 90010}).status, InputStatus::kCounterReset);
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.3), 90020, 90020}).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 0.01, 1e-12);
  EXPECT_GT(odometer.travel()->unseen_variance_m2, 0.0);
}

// Promise unharmed: a gap that may hide a wrap; it is reported
TEST(WheelOdometer, SaysWhenAGapMayHideAWrap) {
  WheelOdometer odometer(geometry(8));  // 128 mm to half the range: 0.128 s at 1 m/s
  odometer.add(WheelCounts{at(0.0), 0, 0});
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.1), 90, 90}).accepted());
  EXPECT_EQ(odometer.add(WheelCounts{at(1.0), 100, 100}).status, InputStatus::kTicksGap);
  EXPECT_NEAR(odometer.travel()->left_m, 0.09, 1e-12);
}

TEST(WheelOdometer, AYearOfSilenceDoesNotHideALaterGap) {
  WheelOdometer odometer(geometry(8));
  constexpr double kYear_s = 3.2e7;
  odometer.add(WheelCounts{at(1.0), 0, 0});
  EXPECT_EQ(odometer.add(WheelCounts{at(kYear_s), 0, 0}).status, InputStatus::kTicksGap);
  const double year_m2 = odometer.travel()->unseen_variance_m2;
  EXPECT_NEAR(year_m2, 100.0 * 100.0 / 3.0, 1e-9);  // uniform to 100 m on either side
  EXPECT_EQ(odometer.add(WheelCounts{at(kYear_s + 2.0), 0, 0}).status, InputStatus::kTicksGap);
  const double reach_m = 1.0 * (2.0 + 0.01) + 2.0 * 1e-3;  // speed, jitter, two ticks
  EXPECT_NEAR(odometer.travel()->unseen_variance_m2 - year_m2, reach_m * reach_m / 3.0, 1e-6);
}

TEST(WheelOdometer, TheSmallerWheelsCounterWrapsFirst) {
  DriveGeometry drive = geometry(8);
  drive.left_wheel_radius_m *= 0.5;  // 64 mm to half the range
  WheelOdometer odometer(drive);
  odometer.add(WheelCounts{at(0.0), 0, 0});
  EXPECT_EQ(odometer.add(WheelCounts{at(0.1), 20, 10}).status, InputStatus::kTicksGap);
}

TEST(WheelOdometer, RefusesWhatIsNotAReading) {
  WheelOdometer odometer(geometry(16));
  EXPECT_EQ(odometer.add(WheelCounts{Stamp(), 0, 0}).status, InputStatus::kNoStamp);
  EXPECT_EQ(odometer.add(WheelCounts{at(0.0), 65536, 0}).status, InputStatus::kTicksOutOfRange);
  EXPECT_FALSE(odometer.travel().has_value());
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.0), 0, 0}).accepted());
  EXPECT_EQ(odometer.add(WheelCounts{at(0.0), 0, 0}).status, InputStatus::kStampNotAfterLast);
  EXPECT_EQ(odometer.add(WheelAngles{at(1.0), std::nan(""), 0.0}).status,
            InputStatus::kAngleNotFinite);
}

// The encoders' clock steps back by up to a second while the wheels turn at 0.9 of the fastest
// speed.
// Promise unharmed: the wheels' clock steps back
TEST(WheelOdometer, LosesNoMotionWhenItsClockStepsBack) {
  for (const double rate_hz : {20.0, 100.0}) {
    for (const double step_s : {0.0, 0.12, 0.2, 0.97}) {
      WheelOdometer odometer(geometry(32));
      unsigned refused = 0;
      for (int i = 0; i <= 1000; ++i) {
        const double time_s = i / rate_hz;
        const std::int64_t ticks = std::lround(900.0 * time_s);
        const InputOutcome outcome =
            odometer.add(WheelCounts{at(i < 500 ? time_s : time_s - step_s), ticks, ticks});
        if (outcome.status == InputStatus::kStampNotAfterLast) {
          ++refused;
        } else {
          ASSERT_TRUE(outcome.accepted()) << describe(outcome) << ", reading " << i;
        }
      }
      EXPECT_EQ(refused, std::floor(rate_hz * step_s + 1e-6)) << "what overlaps, and no more";
      EXPECT_NEAR(odometer.travel()->left_m, 900e-3 * 1000 / rate_hz, 1e-9) << step_s;
      EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0) << step_s;
    }
  }
}

TEST(WheelOdometer, TellsAStepOfItsClockFromALateReading) {
  WheelOdometer odometer(geometry(32));
  for (int i = 0; i <= 10; ++i) odometer.add(WheelCounts{at(0.01 * i), 0, 0});
  odometer.add(WheelCounts{at(-99.0), 0, 0});
  EXPECT_FALSE(odometer.isSteppedBack()) << "one late reading, whatever its stamp";
  EXPECT_EQ(odometer.add(WheelCounts{at(0.11), 200, 200}).status, InputStatus::kTicksTooFast);
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.12), 0, 0}).accepted());
  odometer.add(WheelCounts{at(0.05), 0, 0});
  odometer.add(WheelCounts{at(0.06), 0, 0});
  EXPECT_TRUE(odometer.isSteppedBack());
  EXPECT_TRUE(odometer.add(WheelCounts{at(0.13), 0, 0}).accepted());
  EXPECT_FALSE(odometer.isSteppedBack()) << "they have overtaken";
}

TEST(WheelOdometer, TakesJointPositions) {
  WheelOdometer odometer(geometry(8));
  odometer.add(WheelAngles{at(0.0), 1000.0, -1000.0});
  EXPECT_TRUE(odometer.add(WheelAngles{at(1.0), 1000.0 + kPi, -1000.0 - kPi}).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 0.5, 1e-12);
  EXPECT_NEAR(odometer.travel()->right_m, -0.5, 1e-12);
}

// A wheel of one metre a turn, read at 10 Hz; at 1 m/s it turns by a tenth from one reading to the
// next.
TEST(WheelOdometer, RecoversTheTravelOfJointsThatWrap) {
  for (const double least_rad : {-kPi, 0.0}) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> step_m(-0.08, 0.1);
    WheelOdometer odometer(geometry(32));
    const auto position = [&](double way_m) {  // as a driver that counts in floats
      const double position_rad = 2.0 * kPi * way_m - least_rad;
      return static_cast<double>(static_cast<float>(
          position_rad - 2.0 * kPi * std::floor(position_rad / (2.0 * kPi)) + least_rad));
    };
    double left_m = 0.49;  // about to wrap
    double right_m = -0.01;
    odometer.add(WheelAngles{at(0.0), position(left_m), position(right_m)});
    for (int i = 1; i <= 1000; ++i) {
      left_m += step_m(random);
      right_m += step_m(random);
      const InputOutcome outcome =
          odometer.add(WheelAngles{at(0.1 * i), position(left_m), position(right_m)});
      ASSERT_TRUE(outcome.accepted()) << describe(outcome) << ", reading " << i;
    }
    EXPECT_GT(left_m, 5.0) << "it has wrapped often";
    EXPECT_NEAR(odometer.travel()->left_m, left_m - 0.49, 1e-6);
    EXPECT_NEAR(odometer.travel()->right_m, right_m + 0.01, 1e-6);
    EXPECT_EQ(odometer.travel()->unseen_variance_m2, 0.0);
  }
}

TEST(WheelOdometer, TellsAResetOfAJointFromAWrap) {
  for (const double turns : {3.0, 0.4}) {  // a cumulative joint; any joint, far from where it wraps
    WheelOdometer odometer(geometry(32));
    const double position_rad = 2.0 * kPi * turns;
    odometer.add(WheelAngles{at(0.0), position_rad, position_rad + 0.1});
    EXPECT_EQ(odometer.add(WheelAngles{at(0.1), 0.0, 0.0}).status, InputStatus::kCounterReset)
        << turns;
    EXPECT_EQ(odometer.travel()->left_m, 0.0);
    EXPECT_TRUE(odometer.add(WheelAngles{at(0.2), 0.05, 0.0}).accepted());
  }
}

TEST(WheelOdometer, TakesAFastJointAtItsWordOnceItHasLeftOneTurn) {
  WheelOdometer odometer(geometry(32));
  for (int i = 0; i <= 10; ++i) odometer.add(WheelAngles{at(0.25 * i), 0.5 * kPi * i, 0.0});
  EXPECT_TRUE(odometer.add(WheelAngles{at(3.5), 5.0 * kPi + 1.8 * kPi, 0.0}).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 3.4, 1e-12);
}

TEST(WheelOdometer, SaysWhenAGapMayHideAWrapOfAJoint) {
  WheelOdometer odometer(geometry(32));  // half a turn in half a second at the fastest
  odometer.add(WheelAngles{at(0.0), 3.0, 0.0});
  EXPECT_TRUE(odometer.add(WheelAngles{at(0.4), -3.0, 0.0}).accepted());
  EXPECT_NEAR(odometer.travel()->left_m, 1.0 - 6.0 / (2.0 * kPi), 1e-12);
  EXPECT_EQ(odometer.add(WheelAngles{at(1.0), 3.0, 0.0}).status, InputStatus::kTicksGap);
  EXPECT_TRUE(odometer.add(WheelAngles{at(2.0), 1.0, 0.0}).accepted()) << "no wrap to be seen";
}

// ---- motion between two moments ----

class Track : public ::testing::Test {
 protected:
  /// A robot on a steady arc, read at 100 Hz for `seconds`.
  static OdometryTrack drive(double seconds, double history_s, double anchor_s) {
    OdometryTrack track(kSeparation, kNoise, durationFromSeconds(history_s));
    for (int i = 0; i <= std::lround(100.0 * seconds); ++i) {
      const double t = 0.01 * i;
      track.add({at(t), kLeftSpeed * t, kRightSpeed * t, 0.0});
      if (std::abs(t - anchor_s) < 1e-9) track.anchorAt(at(anchor_s));
    }
    return track;
  }
  static Pose2 exact(double seconds) {
    return arcFromWheels({kLeftSpeed * seconds, kRightSpeed * seconds}, kSeparation).start_from_end;
  }
  static constexpr double kLeftSpeed = 0.15;
  static constexpr double kRightSpeed = 0.20;
};

TEST_F(Track, InterpolatesTheTicksToTheStamp) {
  const OdometryTrack track = drive(2.0, 10.0, 0.5);
  const OdometryIncrement motion = track.motionTo(at(1.2345));
  const Pose2 expected = exact(0.7345);
  EXPECT_LT((motion.start_from_end.position_m - expected.position_m).norm(), 1e-9);
  EXPECT_NEAR(motion.start_from_end.yaw_rad, expected.yaw_rad, 1e-9);
}

TEST_F(Track, LosesNoMotionThatItFoldsAway) {
  const OdometryTrack track = drive(60.0, 1.0, 0.5);  // the anchor is long out of the history
  EXPECT_FALSE(track.covers(at(58.0)));
  ASSERT_TRUE(track.covers(at(59.5)));
  const OdometryIncrement motion = track.motionTo(at(59.5));
  const Pose2 expected = exact(59.0);
  EXPECT_LT((motion.start_from_end.position_m - expected.position_m).norm(), 1e-9);
  EXPECT_NEAR(wrapAngle(motion.start_from_end.yaw_rad - expected.yaw_rad), 0.0, 1e-9);
  EXPECT_NEAR(motion.distance_m, 59.0 * 0.175, 1e-9);
}

// Readings 50 ms apart, stamped on arrival: four in a row are held up, and arrive just before the
// next one. Between those around them the motion is that of a steady speed.
TEST_F(Track, LeavesOutTheReadingsThatArriveTogetherWithALaterOne) {
  OdometryTrack track(kSeparation, kNoise, durationFromSeconds(10.0));
  for (int i = 0; i <= 60; ++i) {
    const double t = 0.05 * i;
    const double held_up_s = i >= 40 && i < 44 ? 0.05 * (44 - i) - 1e-3 * (44 - i) : 0.0;
    track.add({at(t + held_up_s), kLeftSpeed * t, kRightSpeed * t, 0.0});
    if (i == 20) track.anchorAt(at(1.0));
  }
  for (const double t : {1.97, 2.1, 2.1975, 2.25}) {
    const OdometryIncrement motion = track.motionTo(at(t));
    EXPECT_NEAR(motion.distance_m, 0.175 * (t - 1.0), 1e-9) << t;
  }
}

// Readings at four times the usual rate are no late ones. The first look so, until those since the
// last kept one have come at twice the usual rate: four at most.
TEST_F(Track, KeepsTheReadingsOfADriverThatHasBecomeFaster) {
  OdometryTrack track(kSeparation, kNoise, durationFromSeconds(100.0));
  track.add({at(0.0), 0.0, 0.0, 0.0});
  track.anchorAt(at(0.0));
  const auto travelled = [](double t) { return 0.1 * t + 0.05 * std::cos(40.0 * t); };
  double t = 0.0;
  for (int i = 0; i < 300; ++i) {
    t += i < 100 ? 0.08 : 0.02;
    track.add({at(t), travelled(t), travelled(t), 0.0});
  }
  int exactly = 0;
  for (int i = 0; i < 200; ++i) {
    const double moment = 8.0 + 0.02 * (i + 1);
    const double moved_m = track.motionTo(at(moment)).start_from_end.position_m.x();
    if (std::abs(moved_m - travelled(moment)) < 1e-9) ++exactly;
  }
  EXPECT_GE(exactly, 196);
}

TEST_F(Track, RefusesWhatItCannotAnswer) {
  OdometryTrack track = drive(2.0, 10.0, 0.5);
  EXPECT_THROW(track.motionTo(at(3.0)), std::invalid_argument);
  EXPECT_THROW(track.motionTo(at(0.4)), std::invalid_argument);
  EXPECT_THROW(track.anchorAt(at(-1.0)), std::invalid_argument);
  EXPECT_THROW(track.add({at(2.0), 0.0, 0.0, 0.0}), std::invalid_argument);
}

TEST(DriveGeometry, NamesEveryWrongValue) {
  DriveGeometry drive = geometry(12);
  drive.wheel_separation_m = -1.0;
  drive.max_wheel_speed_mps = std::nan("");
  const std::vector<std::string> errors = errorsOf(drive);
  ASSERT_EQ(errors.size(), 3U);
  EXPECT_NE(errors[0].find("wheels/separation"), std::string::npos);
  EXPECT_NE(errors[1].find("wheels/max_speed"), std::string::npos);
  EXPECT_NE(errors[2].find("wheels/counter_bits"), std::string::npos);
}

TEST(WheelNoise, IsOfEitherKind) {
  for (const WheelNoise& noise : {WheelNoise{1e-6, 0.0}, {0.0, 1e-6}, {1e-6, 2e-6}, {2e-6, 1e-6}}) {
    EXPECT_TRUE(errorsOf(noise).empty()) << noise.independent_k_m << " " << noise.common_k_m;
  }
  EXPECT_EQ(errorsOf(WheelNoise{0.0, 0.0}).size(), 1U);
}

}  // namespace
}  // namespace bearing_calibration::core
