#include "bearing_calibration/record/observation_record.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/record/observation_path.h"
#include "bearing_calibration/solve/observability.h"

namespace bearing_calibration::core {
namespace {

const WheelNoise kNoise{1e-6, 0.0};
constexpr double kSeparation_m = 0.25;

Observation observationAfter(double left_m, double right_m, int number) {
  Observation observation;
  observation.stamp = stampFromSeconds(1.0 + 0.1 * number);
  observation.motion = append(OdometryIncrement{}, {left_m, right_m}, kSeparation_m, kNoise);
  observation.azimuth_rad = 0.001 * number;
  observation.azimuth_variance_rad2 = 1e-4;
  return observation;
}

/// The motion over a whole record.
OdometryIncrement wholeMotion(const std::vector<Observation>& observations) {
  OdometryIncrement whole;
  for (std::size_t i = 1; i < observations.size(); ++i)
    whole = append(whole, observations[i].motion);
  return whole;
}

void expectSameMotion(const OdometryIncrement& a, const OdometryIncrement& b) {
  EXPECT_LT((a.start_from_end.position_m - b.start_from_end.position_m).norm(), 1e-9);
  EXPECT_NEAR(wrapAngle(a.start_from_end.yaw_rad - b.start_from_end.yaw_rad), 0.0, 1e-9);
  EXPECT_NEAR(a.distance_m, b.distance_m, 1e-9);
  EXPECT_NEAR(a.rotation_rad, b.rotation_rad, 1e-9);
  EXPECT_LT((a.covariance - b.covariance).norm(), 1e-9 * b.covariance.norm());
}

TEST(ObservationChange, AMirroredMotionIsThatOfSwappedWheels) {
  const OdometryIncrement mirror = mirrored({observationAfter(0.02, 0.3, 1)}).front().motion;
  const OdometryIncrement swapped = observationAfter(0.3, 0.02, 1).motion;
  expectSameMotion(mirror, swapped);
  EXPECT_LT((mirror.J_pose_wheels - swapped.J_pose_wheels).norm(), 1e-12);
}

// A bearing that is late by less than was thought needs the travel around it, too.
TEST(ObservationChange, OtherWheelsHaveOtherTravelAroundEachStamp) {
  std::array<WheelDisplacement, OdometryWindow::kSamples> samples;
  std::array<WheelDisplacement, OdometryWindow::kSamples> swapped;
  for (int i = 0; i < OdometryWindow::kSamples; ++i) {
    samples[static_cast<std::size_t>(i)] = {0.002 * i, 0.001 * i * i};
    swapped[static_cast<std::size_t>(i)] = {0.001 * i * i, 0.002 * i};
  }
  Observation observation = observationAfter(0.02, 0.3, 1);
  observation.nearby = OdometryWindow(samples, kSeparation_m);
  const OdometryWindow expected(swapped, kSeparation_m);
  Eigen::Matrix2d swap;
  swap << 0.0, 1.0, 1.0, 0.0;
  for (const OdometryWindow& changed :
       {mirrored({observation}).front().nearby,
        withOtherWheels({observation}, swap, kSeparation_m, kSeparation_m).front().nearby}) {
    for (const double time_s : {-0.2, -0.06, 0.1}) {
      EXPECT_NEAR(changed.travelTo(time_s).left_m, expected.travelTo(time_s).left_m, 1e-12);
      EXPECT_NEAR(changed.travelTo(time_s).right_m, expected.travelTo(time_s).right_m, 1e-12);
    }
    EXPECT_EQ(changed.wheelSeparation(), kSeparation_m);
  }
}

// What a motion of several arcs is with other wheels, against each of its arcs with other wheels.
TEST(ObservationChange, AMotionOfSeveralArcsIsKeptToFirstOrder) {
  constexpr double kScale = 1.01;
  const std::vector<Eigen::Vector2d> arcs = {{0.5, 0.5}, {-0.6, 0.6}, {0.2, 0.4}};
  Observation observation;
  OdometryIncrement expected;
  for (const Eigen::Vector2d& arc : arcs) {
    observation.motion = append(observation.motion, {arc.x(), arc.y()}, kSeparation_m, {});
    expected = append(expected, {kScale * arc.x(), arc.y()}, kSeparation_m, {});
  }
  const Eigen::Matrix2d wheels = Eigen::Vector2d(kScale, 1.0).asDiagonal();
  const OdometryIncrement changed =
      withOtherWheels({observation}, wheels, kSeparation_m, kSeparation_m).front().motion;
  EXPECT_NEAR(changed.start_from_end.yaw_rad, expected.start_from_end.yaw_rad, 1e-12);
  const double change =
      (expected.start_from_end.position_m - observation.motion.start_from_end.position_m).norm();
  EXPECT_LT((changed.start_from_end.position_m - expected.start_from_end.position_m).norm(),
            0.05 * change);  // the second order: a few times the scale's error
  const OdometryIncrement mirror = mirrored({observation}).front().motion;
  OdometryIncrement swapped;
  for (const Eigen::Vector2d& arc : arcs) {
    swapped = append(swapped, {arc.y(), arc.x()}, kSeparation_m, {});
  }
  EXPECT_NEAR(mirror.start_from_end.yaw_rad, swapped.start_from_end.yaw_rad, 1e-12);
  EXPECT_LT((mirror.start_from_end.position_m - swapped.start_from_end.position_m).norm(), 1e-12);
  EXPECT_LT((mirror.J_pose_wheels - swapped.J_pose_wheels).norm(), 1e-12);
}

// What is not known of the poses adds up from the record's beginning.
TEST(ObservationPath, LosesItsHeadingAndPlaceWithEachMotion) {
  std::vector<Observation> observations;
  for (int i = 0; i < 3; ++i) observations.push_back(observationAfter(0.02, 0.03, i));
  const std::vector<PosedObservation> posed = poseObservations(observations);
  const Eigen::Matrix3d each = observations[1].motion.covariance;
  const Pose2 step = observations[1].motion.start_from_end;
  ASSERT_EQ(posed.size(), 3U);
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const auto motions = static_cast<double>(i);
    EXPECT_NEAR(posed[i].heading_variance_rad2, motions * each(2, 2), 1e-15);
    EXPECT_NEAR(posed[i].position_variance_m2, motions * 0.5 * (each(0, 0) + each(1, 1)), 1e-15);
    EXPECT_NEAR(posed[i].first_from_base.yaw_rad, motions * step.yaw_rad, 1e-12);
  }
}

// Promise bounded: a robot that stands for hours
TEST(ObservationRecord, StandingStillCostsNoRoomAndLosesNoMotion) {
  ObservationRecord record{ObservationRecordConfig()};
  record.add(observationAfter(0.0, 0.0, 0));
  record.add(observationAfter(0.02, 0.01, 1));
  for (int i = 2; i < 50000; ++i) record.add(observationAfter(0.0, 0.0, i));
  EXPECT_LE(record.observations().size(), 2U + kMostRepetitions);
  EXPECT_EQ(record.observations().back().stamp, observationAfter(0.0, 0.0, 49999).stamp);
  expectSameMotion(wholeMotion(record.observations()), observationAfter(0.02, 0.01, 1).motion);
}

TEST(ObservationRecord, CreepingIsNotStandingStill) {
  constexpr double kCreep_m = 1e-4;  // per observation: 20 of them make a distance that counts
  ObservationRecord record{ObservationRecordConfig()};
  for (int i = 0; i < 1000; ++i) record.add(observationAfter(kCreep_m, kCreep_m, i));
  EXPECT_NEAR(wholeMotion(record.observations()).distance_m, 999 * kCreep_m, 1e-9);
  EXPECT_GT(record.observations().size(), 40U);
}

// Promise bounded: a drive without end
TEST(ObservationRecord, AnEndlessDriveIsKeptWholeOnlyCoarser) {
  ObservationRecordConfig config;
  config.capacity = 200;
  ObservationRecord record(config);
  OdometryIncrement whole;
  for (int i = 0; i < 5000; ++i) {
    const Observation observation = observationAfter(0.02, i % 100 < 50 ? 0.02 : 0.01, i);
    if (i > 0) whole = append(whole, observation.motion);
    record.add(observation);
    ASSERT_LE(record.observations().size(), config.capacity);
  }
  expectSameMotion(wholeMotion(record.observations()), whole);
  EXPECT_EQ(record.observations().front().stamp, stampFromSeconds(1.0));
  double longest_m = 0.0;
  for (const Observation& observation : record.observations()) {
    longest_m = std::max(longest_m, observation.motion.distance_m);
  }
  // evenly spread would be whole / capacity; pairs are merged, so nothing is longer than a few
  EXPECT_LT(longest_m, 4.0 * whole.distance_m / static_cast<double>(config.capacity));
}

// Way and turns go on where a record was cut, however often: a verdict is held over them.
TEST(ObservationRecord, WhatIsGivenAwayLeavesItsWayAndItsTurns) {
  ObservationRecord record{ObservationRecordConfig()};
  StateEstimate known;
  known.layout = {0, 1};
  for (int i = 0; i < 300; ++i) {
    record.add(observationAfter(0.02, 0.01, i));
    known.mean = StateVector::Constant(known.layout.size(), i);
    if (i % 100 == 99) record.cut({60, known, {}});
  }
  ASSERT_TRUE(record.beginning().has_value());
  const OdometryIncrement motion = observationAfter(0.02, 0.01, 0).motion;
  constexpr int kGivenAway = 180;  // the first one's motion counts as none
  EXPECT_EQ(record.observations().size(), 300U - kGivenAway);
  EXPECT_EQ(record.observations().front().stamp, observationAfter(0.0, 0.0, kGivenAway).stamp);
  EXPECT_NEAR(record.beginning()->distance_m, (kGivenAway - 1) * motion.distance_m, 1e-9);
  EXPECT_NEAR(record.beginning()->rotation_rad, (kGivenAway - 1) * motion.rotation_rad, 1e-9);
  EXPECT_EQ(record.beginning()->known.mean(0), 299.0);
  EXPECT_EQ(record.grown(), 300U);
  record.clear();
  EXPECT_FALSE(record.beginning().has_value());
}

TEST(ObservationRecord, RefusesARecordTooSmallToBeOfUse) {
  ObservationRecordConfig config;
  config.capacity = 3;
  EXPECT_THROW(ObservationRecord{config}, std::invalid_argument);
}

TEST(Thinned, KeepsTheLastObservationAndAllMotion) {
  std::vector<Observation> observations;
  for (int i = 0; i < 1003; ++i) observations.push_back(observationAfter(0.02, 0.015, i));
  const std::vector<Observation> few = thinned(observations, 100);
  EXPECT_LE(few.size(), 101U);
  EXPECT_EQ(few.back().stamp, observations.back().stamp);
  OdometryIncrement to_first = few.front().motion;  // since before the whole record
  for (std::size_t i = 1; i < few.size(); ++i) to_first = append(to_first, few[i].motion);
  EXPECT_NEAR(to_first.distance_m, 1003 * 0.0175, 1e-9);
}

/// Two metres straight ahead, and to the left on a circle of 0.5 m from there on.
Pose2 poseAfter(double way_m) {
  constexpr double kStraight_m = 2.0, kRadius_m = 0.5;
  const double turn_rad = std::max(0.0, way_m - kStraight_m) / kRadius_m;
  return {{std::min(way_m, kStraight_m) + kRadius_m * std::sin(turn_rad),
           kRadius_m * (1.0 - std::cos(turn_rad))},
          turn_rad};
}

TEST(WithEarlierBearings, TheyAreTakenOnTheWayToTheirStamps) {
  constexpr double kStep_m = 0.04;
  constexpr double kHalf = 0.5 * kSeparation_m / 0.5;  // of the separation over the circle's radius
  std::vector<Observation> observations;
  for (int i = 0; i < 100; ++i) {
    const double curved = i > 50 ? kHalf : 0.0;
    observations.push_back(observationAfter(kStep_m * (1.0 - curved), kStep_m * (1.0 + curved), i));
  }
  const auto earlier = withEarlierBearings(observations, 0.025, kSeparation_m);  // of 0.1 s
  ASSERT_EQ(earlier.size(), 99U);  // where the robot was before the first one, nobody knows
  Pose2 pose;
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    pose = pose * earlier[i].motion.start_from_end;
    const Pose2 expected = poseAfter(kStep_m * (static_cast<double>(i) + 0.75));
    EXPECT_LT((pose.position_m - expected.position_m).norm(), 1e-7) << i;
    EXPECT_NEAR(wrapAngle(pose.yaw_rad - expected.yaw_rad), 0.0, 1e-7) << i;
    EXPECT_EQ(earlier[i].azimuth_rad, observations[i + 1].azimuth_rad);
  }
}

TEST(SummariseMotion, TellsOneCurvatureFromTwo) {
  std::vector<Observation> line, circle, spin, line_and_spin;
  for (int i = 0; i < 100; ++i) {
    line.push_back(observationAfter(0.02, 0.02, i));
    circle.push_back(observationAfter(0.02, 0.01, i));
    spin.push_back(observationAfter(-0.01, 0.01, i));
    line_and_spin.push_back(i < 50 ? observationAfter(0.02, 0.02, i)
                                   : observationAfter(-0.01, 0.01, i));
  }
  EXPECT_LT(summariseMotion(line).second_curvature_m, 1e-9);
  EXPECT_LT(summariseMotion(circle).second_curvature_m, 1e-9);
  EXPECT_LT(summariseMotion(spin).second_curvature_m, 1e-9);
  // 49 steps of 2 cm straight; 50 turns of 0.08 rad at the lever of 0.3 m are more than that
  EXPECT_NEAR(summariseMotion(line_and_spin).second_curvature_m, 49 * 0.02, 1e-9);
  EXPECT_NEAR(summariseMotion(line).extent_m, 99 * 0.02, 1e-9);
}

// A break in the readings leaves the heading open by half a radian, or more: no filter follows it.
TEST(SummariseMotion, TheNoiseOfItsExtentIsThatOfMotionsWithoutABreak) {
  std::vector<Observation> record;
  for (int i = 0; i < 4; ++i) record.push_back(observationAfter(0.02, 0.02, i));
  for (Observation& observation : record)
    observation.motion.covariance.diagonal().setConstant(1e-4);
  EXPECT_NEAR(summariseMotion(record).extent_noise_m, std::sqrt(3.0 * 1e-4), 1e-12);
  record[2].motion.covariance.diagonal() << 0.04, 0.04, 0.49 * 0.49;
  EXPECT_NEAR(summariseMotion(record).extent_noise_m, std::sqrt(0.04 + 2.0 * 1e-4), 1e-12);
  record[2].motion.covariance(2, 2) = 0.51 * 0.51;
  EXPECT_NEAR(summariseMotion(record).extent_noise_m, std::sqrt(2.0 * 1e-4), 1e-12);
}

TEST(WeakestDirection, IsTheLongestAxisWithYawAsALength) {
  CartesianEstimate estimate;
  estimate.mean << 3.0, 4.0, 0.0, 0.0, 0.0;  // range 5 m
  estimate.covariance.diagonal() << 1e-4, 1e-4, 1e-4, 1e-4, 1e-3;
  const WeakestDirection weakest = weakestDirection(estimate);
  EXPECT_NEAR(weakest.lever_m, 5.0, 1e-12);
  EXPECT_NEAR(weakest.stddev_m, 5.0 * std::sqrt(1e-3), 1e-12);
  EXPECT_NEAR(std::abs(weakest.direction(CartesianIndex::kSensorYaw)), 1.0, 1e-12);
}

// A robot that drives before it sees the light for the first time has told nothing of the mount.
TEST(Initializer, TheMotionBeforeItsFirstObservationCountsAsNone) {
  Initializer initializer{InitializerConfig()};
  initializer.add(observationAfter(3.0, 3.1, 0));
  initializer.add(observationAfter(0.02, 0.03, 1));
  const std::vector<Observation>& observations = initializer.record().observations();
  EXPECT_EQ(observations[0].motion.distance_m, 0.0);
  EXPECT_EQ(observations[0].motion.rotation_rad, 0.0);
  EXPECT_NEAR(observations[1].motion.distance_m, 0.025, 1e-12);
}

}  // namespace
}  // namespace bearing_calibration::core
