// The parts of a drive: primitives, their prediction, the region, the planner, and the follower.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <deque>
#include <iostream>
#include <random>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/planning/drive_script.h"
#include "bearing_calibration/planning/motion_planner.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSeparation_m = 0.25;
const WheelLimits kLimits{kSeparation_m, 0.2, 0.5};
const SensingModel kSensing{{1e-6, 0.0}, kPi / 180.0, 10.0};
const PlannerConfig kPlanner{PlannerConfig::Block::kMount, 0.5, 2.0, 0.1, 1.0};

/// Of a robot without doubts of its clock and wheels.
StateEstimate estimateAt(double light_x_m, double light_y_m, double stddev) {
  CartesianEstimate robot;
  robot.mean << light_x_m, light_y_m, 0.08, 0.05, 1.0;
  robot.covariance = stddev * stddev * Matrix5::Identity();
  return StateEstimate::of(robot);
}

double logDetOf(const MountEstimate& mount) { return std::log(mount.covariance.determinant()); }

TEST(MotionPrimitive, TravelsByTrapezoidWithinTheLimits) {
  // long way: cruise; ramps of 0.4 s and 0.04 m each
  EXPECT_DOUBLE_EQ(travelTime(1.0, kLimits), 1.0 / 0.2 + 0.4);
  EXPECT_DOUBLE_EQ(travelAt(0.2, 1.0, kLimits), 0.5 * 0.5 * 0.2 * 0.2);
  EXPECT_DOUBLE_EQ(travelAt(0.4 + 1.0, 1.0, kLimits), 0.04 + 0.2);
  // short way: a triangle
  EXPECT_DOUBLE_EQ(travelTime(0.02, kLimits), 2.0 * std::sqrt(0.02 / 0.5));
  EXPECT_DOUBLE_EQ(travelAt(0.5 * travelTime(0.02, kLimits), 0.02, kLimits), 0.01);
  for (const double way_m : {1.0, -1.0, 0.02, -0.08}) {
    const double whole_s = travelTime(way_m, kLimits);
    EXPECT_NEAR(travelAt(whole_s, way_m, kLimits), way_m, 1e-12);
    EXPECT_DOUBLE_EQ(travelAt(0.0, way_m, kLimits), 0.0);
    constexpr double kStep_s = 1e-3;
    double speed_before = 0.0;
    for (double time_s = 0.0; time_s < whole_s; time_s += kStep_s) {
      const double speed =
          (travelAt(time_s + kStep_s, way_m, kLimits) - travelAt(time_s, way_m, kLimits)) / kStep_s;
      EXPECT_LE(std::abs(speed), kLimits.max_speed_mps + 1e-9);
      EXPECT_LE(std::abs(speed - speed_before), kLimits.max_acceleration_mps2 * kStep_s + 1e-9);
      speed_before = speed;
    }
  }
}

/// What the calibration looks for by default: clock and wheels.
ErrorEstimate usualDoubts() {
  ErrorPriors doubts;
  doubts.setBlock(TimeOffset::kName, 0.1);
  doubts.setBlock(WheelScales::kName, 0.03);
  doubts.setBlock(WheelSeparation::kName, 0.01);
  return priorEstimate(doubts);
}

/// Travel around a moment of one part of a primitive.
OdometryWindow nearbyAt(double time_s, const WheelDisplacement& whole) {
  std::array<WheelDisplacement, OdometryWindow::kSamples> samples;
  for (int i = 0; i < OdometryWindow::kSamples; ++i) {
    const double sample_s = time_s + (i - OdometryWindow::kBefore) * OdometryWindow::kStep_s;
    const double share = travelAt(sample_s, whole.right_m, kLimits) / whole.right_m;
    samples[static_cast<std::size_t>(i)] = {share * whole.left_m, share * whole.right_m};
  }
  return {samples, kSeparation_m};
}

/// The filter itself, fed with every bearing along the primitive that the sensor sees.
/// @param bearings  counts them
StateEstimate filteredAfter(const MotionPrimitive& primitive, const StateEstimate& start,
                            const FieldOfView& view = {}, int* bearings = nullptr) {
  LiveFilter filter(start);
  for (const WheelDisplacement& whole :
       {turningWheels(primitive, kSeparation_m), straightWheels(primitive)}) {
    const double period_s = 1.0 / kSensing.bearing_rate_hz;
    double before = 0.0;
    const double whole_s = travelTime(whole.right_m, kLimits);
    for (double time_s = period_s; time_s <= whole_s + 0.5 * period_s; time_s += period_s) {
      const double now = travelAt(time_s, whole.right_m, kLimits) / whole.right_m;
      const double part = now - before;
      before = now;
      filter.predict(append({}, {part * whole.left_m, part * whole.right_m}, kSeparation_m,
                            kSensing.wheel_noise, 0.0));
      const OdometryWindow nearby = nearbyAt(time_s, whole);
      Bearing bearing;
      bearing.azimuth_rad = filter.predictAzimuth(nearby).azimuth_rad;
      bearing.azimuth_variance_rad2 = std::pow(kSensing.bearing_stddev_rad, 2);
      const double off_rad = std::remainder(bearing.azimuth_rad - view.centre_rad, 2.0 * kPi);
      if (view.isLimited() && std::abs(off_rad) > 0.5 * view.width_rad) continue;
      filter.update(bearing, nearby);
      if (bearings != nullptr) ++*bearings;
    }
  }
  return filter.estimate();
}

/// Who does not doubt wheels that the calibration doubts expects too much of a straight way.
TEST(PrimitivePrediction, IsWhatTheFilterWillSay) {
  for (const ErrorEstimate& errors : {ErrorEstimate(), usualDoubts()}) {
    const StateEstimate start =
        StateEstimate::of(estimateAt(0.7, 0.4, 0.02).cartesian(), kWheelErrors, errors);
    for (const MotionPrimitive primitive :
         {MotionPrimitive{0.0, 0.6}, MotionPrimitive{-4.5, 0.0}, MotionPrimitive{1.2, -0.8},
          MotionPrimitive{7.0, 0.5}}) {
      const StateEstimate predicted = predictAfter(primitive, start, kLimits, kSensing);
      const StateEstimate filtered = filteredAfter(primitive, start);
      EXPECT_LT((predicted.mean - filtered.mean).norm(), 0.01) << primitive.turn_rad;
      // steps of up to a quarter of a second instead of a tenth: a few percent of each deviation
      EXPECT_NEAR(logDetOf(predicted.mount()), logDetOf(filtered.mount()), 0.2)
          << primitive.turn_rad;
      for (int i = 0; i < kWheelErrors; ++i) {
        EXPECT_NEAR(std::sqrt(predicted.errors().covariance(i, i)),
                    std::sqrt(filtered.errors().covariance(i, i)),
                    0.1 * std::sqrt(errors.covariance(i, i)))
            << primitive.turn_rad << ", error " << i;
      }
    }
  }
}

SensingModel seeing(const FieldOfView& view) {
  SensingModel sensing = kSensing;
  sensing.view = view;
  return sensing;
}

/// Of a turn on the spot a sensor of 60 deg sees a sixth, of a way past the light the part ahead.
TEST(PrimitivePrediction, CountsBearingsInViewOnly) {
  const StateEstimate start = estimateAt(0.7, 0.4, 0.02);
  for (const FieldOfView view : {FieldOfView{0.3, kPi / 3.0}, FieldOfView{-2.5, kPi}}) {
    for (const MotionPrimitive primitive :
         {MotionPrimitive{2.0 * kPi, 0.0}, MotionPrimitive{-4.5, 0.0}, MotionPrimitive{1.0, 0.8},
          MotionPrimitive{7.0, -0.5}}) {
      int bearings = 0;
      const StateEstimate filtered = filteredAfter(primitive, start, view, &bearings);
      const StateEstimate predicted = predictAfter(primitive, start, kLimits, seeing(view));
      const StateEstimate all_around = predictAfter(primitive, start, kLimits, kSensing);
      // As above, and at each border that a turn passes half a step's bearings and one of the
      // filter's, which no direction gains more by than by their share in all of them.
      const double borders = 1.0 + std::abs(primitive.turn_rad) / kPi;
      const double tolerance = 0.2 + 3.0 * std::log1p(2.25 * borders / bearings);
      EXPECT_NEAR(logDetOf(predicted.mount()), logDetOf(filtered.mount()), tolerance)
          << view.centre_rad << ", " << primitive.turn_rad;
      EXPECT_GT(logDetOf(predicted.mount()), logDetOf(all_around.mount()));
    }
  }
}

TEST(PrimitivePrediction, OfALightThatIsNeverInViewLearnsNothing) {
  const StateEstimate start = estimateAt(2.0, 0.0, 0.01);
  const double azimuth_rad = LiveFilter(start).predictAzimuth().azimuth_rad;
  const SensingModel sensing = seeing({azimuth_rad + kPi, 1.0});
  EXPECT_GE(logDetOf(predictAfter({0.0, 0.5}, start, kLimits, sensing).mount()),
            logDetOf(start.mount()));
}

// Promise bounded: a field of view so narrow that planning a turn would take billions of steps
TEST(PrimitivePrediction, TakesTheWholeTurnHoweverNarrowTheViewIs) {
  const StateEstimate start = estimateAt(2.0, 0.0, 0.01);
  const Eigen::Vector2d behind(0.0, -2.0);  // the light, after a quarter of a turn to the left
  for (const double width_rad : {1.0, 1e-3, 1e-12}) {
    const StateEstimate turned =
        predictAfter({0.5 * kPi, 0.0}, start, kLimits, seeing({0.0, width_rad}));
    EXPECT_LT((turned.mean.tail<2>() - behind).norm(), 0.01) << width_rad;
  }
}

TEST(LightClearance, IsTheLeastDistanceMinusItsOwnDeviations) {
  StateEstimate robot = estimateAt(1.0, 0.5, 0.0);
  const auto clearance = [&](const MotionPrimitive& primitive) {
    return lightClearance(primitive, robot, 2.0);
  };
  EXPECT_DOUBLE_EQ(clearance({0.0, 2.0}), 0.5);                    // passes it
  EXPECT_DOUBLE_EQ(clearance({0.0, -2.0}), std::hypot(1.0, 0.5));  // leaves
  EXPECT_NEAR(clearance({0.5 * kPi, 0.2}), std::hypot(1.0, 0.3), 1e-12);
  robot.covariance(3, 3) = 0.01;  // along the way: no matter beside the light
  EXPECT_DOUBLE_EQ(clearance({0.0, 2.0}), 0.5);
  robot.covariance(4, 4) = 0.01;
  EXPECT_NEAR(clearance({0.0, 2.0}), 0.3, 1e-12);
}

TEST(Region, DiscAndPolygonKnowTheirBorders) {
  const Region disc{2.0, {}};
  EXPECT_DOUBLE_EQ(disc.clearance({0.0, 0.0}, {1.5, 0.0}), 0.5);
  EXPECT_DOUBLE_EQ(disc.clearance({0.0, 2.5}), -0.5);
  // an L: the straight way between its arms leaves it
  const Region corner{0.0, {{-1, -1}, {3, -1}, {3, 1}, {1, 1}, {1, 3}, {-1, 3}}};
  EXPECT_TRUE(errorsOf(corner).empty());
  EXPECT_DOUBLE_EQ(corner.clearance({0.0, 0.0}), 1.0);
  EXPECT_DOUBLE_EQ(corner.clearance({0.0, 0.0}, {2.5, 0.0}), 0.5);
  EXPECT_LE(corner.clearance({0.0, 2.5}, {2.5, 0.0}), 0.0);
  EXPECT_DOUBLE_EQ(corner.clearance({2.0, 2.0}), -1.0);
  EXPECT_FALSE(errorsOf(Region{0.0, {{1, 1}, {2, 1}, {2, 2}}}).empty());
  EXPECT_FALSE(errorsOf(Region{0.0, {{-1, -1}, {1, 1}, {1, -1}, {-1, 1}}}).empty());
  EXPECT_FALSE(errorsOf(Region{0.0, {}}).empty());
}

/// Its ends lie inside, 0.5 m from the border at least; the way between them does not.
TEST(MotionPlanner, DrivesNoWayOutOfItsRegionPastAnInwardCornerWithoutAMargin) {
  const Region corner{0.0, {{-1, -1}, {3, -1}, {3, 1}, {1, 1}, {1, 3}, {-1, 3}}};
  PlannerConfig config = kPlanner;
  config.region_margin_m = 0.0;
  const MotionPlanner planner(config, kLimits, kSensing, corner);
  const Pose2 start_from_base{{0.0, 2.5}, -0.25 * kPi};
  const double length_m = 2.5 * std::sqrt(2.0);
  EXPECT_FALSE(planner.staysInside({0.0, length_m}, start_from_base));
  EXPECT_LT(corner.clearance({0.0, 2.5}, {2.5, 0.0}), 0.0);
  EXPECT_TRUE(planner.staysInside({-0.25 * kPi, 2.0}, start_from_base));
}

/// Whatever it knows, it neither comes too near to the light nor leaves the region, and it learns.
TEST(MotionPlanner, PlansOnlyWhatIsAllowed) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Region region{2.0, {}};
  const MotionPlanner planner(kPlanner, kLimits, kSensing, region);
  for (int i = 0; i < 50; ++i) {
    const double distance_m = 0.55 + 2.5 * uniform(engine);
    const Eigen::Vector2d light =
        rotation2(2.0 * kPi * uniform(engine)) * Eigen::Vector2d(distance_m, 0.0);
    const StateEstimate estimate =
        estimateAt(light.x(), light.y(), std::pow(10.0, -3.0 + 1.2 * uniform(engine)));
    const Pose2 start_from_base{1.8 * Eigen::Vector2d(uniform(engine), 0.0),
                                2.0 * kPi * uniform(engine)};
    const auto plan = planner.plan(estimate, start_from_base);
    ASSERT_TRUE(plan) << i;
    const double here_m = lightClearance({}, estimate, 2.0);
    EXPECT_GE(lightClearance(plan->primitive, estimate, 2.0), std::min(0.5, here_m)) << i;
    const Pose2 there = poseAfter(plan->primitive, start_from_base);
    EXPECT_GE(region.clearance(start_from_base.position_m, there.position_m), 0.1 - 1e-12) << i;
    EXPECT_LT(logDetOf(plan->expected), logDetOf(estimate.mount())) << i;
  }
}

/// What the follower makes of a plan is allowed, too: a turn that is too small to be driven must
/// not be what keeps the way off the light. Else the robot would give up each primitive at once,
/// and stand.
TEST(MotionPlanner, PlansWhatIsDriven) {
  const MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int straight_on = 0;
  for (int i = 0; i < 100; ++i) {  // the light where the nearest way past it begins with no turn
    const double distance_m = 0.55 + 0.3 * uniform(engine);
    const double off_rad = radiansFromDegrees(1.2 * (uniform(engine) - 0.5));
    const double tangent_rad = std::asin(kPlanner.light_distance_m / distance_m);
    const Eigen::Vector2d light =
        rotation2(tangent_rad + off_rad) * Eigen::Vector2d(distance_m, 0.0);
    const StateEstimate estimate = estimateAt(light.x(), light.y(), 1e-3);
    const auto plan = planner.plan(estimate, {});
    ASSERT_TRUE(plan) << i;
    const MotionPrimitive driven = PrimitiveFollower(plan->primitive, kLimits, {}).remaining({});
    EXPECT_TRUE(planner.keepsAway(driven, estimate)) << i;
    straight_on += driven.turn_rad == 0.0 ? 1 : 0;
  }
  EXPECT_GT(straight_on, 10);
}

/// A way that somebody asked for is refused when the light is surely near, not when it may be.
TEST(MotionPlanner, RefusesAnAskedForWayOnlyWhenTheLightIsSurelyNear) {
  const MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
  const MotionPrimitive past{0.0, 1.0};  // 0.45 m from the light's most probable place
  const StateEstimate vague = estimateAt(0.5, 0.45, 0.1);
  const StateEstimate sharp = estimateAt(0.5, 0.45, 0.01);
  EXPECT_FALSE(planner.keepsAway(past, vague));
  EXPECT_TRUE(planner.keepsAway(past, vague, true));
  EXPECT_FALSE(planner.keepsAway(past, sharp, true));
  EXPECT_TRUE(planner.keepsAway({kPi, 1.0}, sharp, true));  // away from it
}

/// However many bearings are expected, what none of them tells stays.
TEST(MotionPlanner, PromisesNothingThatNoBearingTells) {
  constexpr double kNearness_m = 0.005;
  const StateEstimate estimate = estimateAt(0.7, 0.3, 0.001);
  MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
  planner.setNearness(kNearness_m);
  const auto plan = planner.plan(estimate, {});
  ASSERT_TRUE(plan);
  StateEstimate after = predictAfter(plan->primitive, estimate, kLimits, kSensing);
  after = predictAfter(plan->next, after, kLimits, kSensing);
  Eigen::Matrix3d expected = after.mount().covariance;
  expected.diagonal().head<2>().array() += kNearness_m * kNearness_m;
  EXPECT_LT((plan->expected.covariance - expected).norm(), 1e-15);
}

TEST(MotionPlanner, LeavesALightThatIsTooNear) {
  const MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
  const auto plan = planner.plan(estimateAt(0.25, 0.1, 0.01), {});
  ASSERT_TRUE(plan);
  EXPECT_GE(lightClearance(plan->primitive, estimateAt(0.25, 0.1, 0.0), 0.0),
            std::hypot(0.25, 0.1) - 1e-9);
}

/// Also from those that it does not plan by.
TEST(MotionPlanner, KeepsAwayFromEachLight) {
  const MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
  const StateEstimate one = estimateAt(1.2, 0.0, 0.001);
  const StateEstimate both = withLight(one, {0.6, 0.45}, 1e-6 * Eigen::Matrix2d::Identity());
  const auto best = planner.plan(one, {});
  const auto plan = planner.plan(both, {});
  ASSERT_TRUE(best && plan);
  EXPECT_LT(lightClearance(best->primitive, both, 2.0, 1), 0.5) << "it stands in the way";
  EXPECT_FALSE(planner.keepsAway(best->primitive, both, true));
  for (int light = 0; light < 2; ++light) {
    EXPECT_GE(lightClearance(plan->primitive, both, 2.0, light), 0.5) << light;
  }
}

// As after a resume: each is at 2 m, give or take a metre.
TEST(MotionPlanner, SeveralLightsThatMayBeAnywhereLeaveAWay) {
  const MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
  StateEstimate estimate = estimateAt(2.0, 0.0, 1.0);
  for (const double azimuth_rad : {2.0 * kPi / 3.0, -2.0 * kPi / 3.0}) {
    const Eigen::Vector2d place_m =
        2.0 * Eigen::Vector2d(std::cos(azimuth_rad), std::sin(azimuth_rad));
    estimate = withLight(estimate, place_m, Eigen::Matrix2d::Identity());
  }
  EXPECT_TRUE(planner.plan(estimate, {}));
}

TEST(MotionPlanner, HasNoPlanWithoutRoom) {
  const MotionPlanner planner(kPlanner, kLimits, kSensing, {0.11, {}});
  EXPECT_FALSE(planner.plan(estimateAt(1.0, 0.0, 0.01), {}));
}

/// A chosen block is served better than by a plan for another one.
TEST(MotionPlanner, ServesTheChosenBlock) {
  const StateEstimate estimate = estimateAt(0.7, 0.3, 0.02);
  const auto stddevOfYaw = [&](PlannerConfig::Block block) {
    PlannerConfig config = kPlanner;
    config.block = block;
    const MotionPlanner planner(config, kLimits, kSensing, {4.0, {}});
    StateEstimate now = estimate;
    Pose2 pose;
    double time_s = 0.0;
    while (time_s < 30.0) {
      const auto plan = planner.plan(now, pose);
      time_s += durationOf(plan->primitive, kLimits);
      now = predictAfter(plan->primitive, now, kLimits, kSensing);
      pose = poseAfter(plan->primitive, pose);
    }
    return std::sqrt(now.mount().covariance(2, 2));
  };
  EXPECT_LT(stddevOfYaw(PlannerConfig::Block::kYaw), stddevOfYaw(PlannerConfig::Block::kPosition));
}

/// Drives by plans, and lets the filter see what the sensor sees on the way.
struct PlannedDrive {
  PlannedDrive(const FieldOfView& view, const FieldOfView& told, double yaw_rad) {
    CartesianEstimate robot;
    robot.mean << 0.9, 0.4, 0.08, 0.05, yaw_rad;
    robot.covariance = 1e-4 * Matrix5::Identity();
    predicted = filtered = StateEstimate::of(robot);
    MotionPlanner planner(kPlanner, kLimits, kSensing, {4.0, {}});
    planner.setView(told);
    Pose2 pose;
    for (double time_s = 0.0; time_s < 20.0;) {
      const auto plan = planner.plan(filtered, pose);
      time_s += durationOf(plan->primitive, kLimits);
      predicted = predictAfter(plan->primitive, predicted, kLimits, seeing(view));
      filtered = filteredAfter(plan->primitive, filtered, view, &bearings);
      pose = poseAfter(plan->primitive, pose);
    }
  }

  StateEstimate predicted;  ///< as the planner would
  StateEstimate filtered;
  int bearings = 0;
};

/// Wherever on the robot it looks: the plan sees the light more often, learns more, and says how
/// much.
TEST(MotionPlanner, KeepsTheLightInView) {
  const FieldOfView view{0.2, kPi / 3.0};
  for (const double yaw_rad : {0.0, 1.6, 3.0}) {
    const PlannedDrive knowing(view, view, yaw_rad);
    const PlannedDrive unknowing(view, {}, yaw_rad);
    std::cout << "bearings in 20 s: " << knowing.bearings << " where the planner knows, "
              << unknowing.bearings << " where it does not\n";
    EXPECT_GT(knowing.bearings, 1.3 * unknowing.bearings) << yaw_rad;
    EXPECT_LT(logDetOf(knowing.filtered.mount()), logDetOf(unknowing.filtered.mount())) << yaw_rad;
    // Each border that a turn passes may be off by two bearings of some ten (see above): a fifth of
    // the deviations. Without its knowledge of the field of view they would be off by a half.
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(std::sqrt(knowing.predicted.mount().covariance(i, i) /
                            knowing.filtered.mount().covariance(i, i)),
                  1.0, 0.1)
          << yaw_rad << ", " << i;
    }
  }
}

/// Wheels that do what they are told, some time later, read back some time later; but nothing below
/// their least speed.
class LateWheels {
 public:
  explicit LateWheels(int late_periods, double least_mps = 0.0)
      : least_mps_(least_mps), commands_(static_cast<std::size_t>(late_periods)) {}

  WheelDisplacement drive(const WheelSpeeds& command, double period_s) {
    commands_.push_back(command);
    travelled_.left_m += period_s * rolled(commands_.front().left_mps);
    travelled_.right_m += period_s * rolled(commands_.front().right_mps);
    commands_.pop_front();
    return travelled_;
  }

 private:
  double rolled(double speed_mps) const { return std::abs(speed_mps) < least_mps_ ? 0 : speed_mps; }

  double least_mps_;
  std::deque<WheelSpeeds> commands_;
  WheelDisplacement travelled_;
};

TEST(PrimitiveFollower, ArrivesWithinTheLimitsWithLateWheels) {
  constexpr double kPeriod_s = 0.05;
  for (const MotionPrimitive primitive :
       {MotionPrimitive{0.0, 1.0}, MotionPrimitive{-5.0, -0.4}, MotionPrimitive{2.0 * kPi, 0.0},
        MotionPrimitive{0.01, 0.02}}) {
    LateWheels wheels(2);
    WheelDisplacement travelled;
    PrimitiveFollower follower(primitive, kLimits, travelled);
    WheelSpeeds before;
    int steps = 0;
    while (!follower.done() && steps++ < 2000) {
      const WheelSpeeds next = follower.steer(travelled, before, kPeriod_s);
      for (const auto& [now, last] : {std::pair{next.left_mps, before.left_mps},
                                      std::pair{next.right_mps, before.right_mps}}) {
        EXPECT_LE(std::abs(now), kLimits.max_speed_mps + 1e-12);
        EXPECT_LE(std::abs(now - last), kLimits.max_acceleration_mps2 * kPeriod_s + 1e-12);
      }
      EXPECT_FALSE(follower.isDisobeyed(travelled));
      before = next;
      travelled = wheels.drive(next, kPeriod_s);
    }
    ASSERT_TRUE(follower.done()) << primitive.turn_rad;
    EXPECT_TRUE(isStanding(before));
    const double turned_rad = (travelled.right_m - travelled.left_m) / kSeparation_m;
    EXPECT_NEAR(0.5 * (travelled.right_m + travelled.left_m), primitive.length_m, 0.01);
    EXPECT_NEAR(turned_rad, primitive.turn_rad, 0.06);
  }
}

TEST(PrimitiveFollower, StandsAsSoonAsItCanWhenAbandoned) {
  constexpr double kPeriod_s = 0.05;
  PrimitiveFollower follower({0.0, 1.0}, kLimits, {});
  WheelSpeeds before{0.2, 0.2};
  follower.abandon();
  int steps = 0;
  while (!follower.done() && steps++ < 100) before = follower.steer({0.1, 0.1}, before, kPeriod_s);
  EXPECT_EQ(steps, 8);  // 0.2 m/s at 0.5 m/s^2 is 0.4 s
  EXPECT_TRUE(isStanding(before));
}

TEST(PrimitiveFollower, NoticesWheelsThatDisobey) {
  PrimitiveFollower reversed({0.0, 1.0}, kLimits, {});
  EXPECT_FALSE(reversed.isDisobeyed({-0.05, -0.05}));
  EXPECT_TRUE(reversed.isDisobeyed({-0.15, -0.15}));
  PrimitiveFollower stuck({0.0, 0.1}, kLimits, {});
  WheelSpeeds command;
  for (int i = 0; i < 200 && !stuck.isDisobeyed({}); ++i) command = stuck.steer({}, command, 0.05);
  EXPECT_TRUE(stuck.isDisobeyed({}));
}

// A half of the speed is a robot's own; a quarter, wheels that are said to be four times as large.
TEST(PrimitiveFollower, NoticesWheelsThatRollAtAQuarterOfTheirSpeed) {
  constexpr double kPeriod_s = 0.05;
  for (const MotionPrimitive primitive :
       {MotionPrimitive{0.0, 2.0}, MotionPrimitive{-2.5 * kPi, 0.0}}) {
    for (const double share : {0.5, 0.25}) {
      PrimitiveFollower follower(primitive, kLimits, {});
      WheelSpeeds command;
      WheelDisplacement travelled;
      for (int steps = 0; steps < 2000 && !follower.isDisobeyed(travelled); ++steps) {
        command = follower.steer(travelled, command, kPeriod_s);
        travelled.left_m += kPeriod_s * share * command.left_mps;
        travelled.right_m += kPeriod_s * share * command.right_mps;
      }
      EXPECT_EQ(follower.done(), share == 0.5) << primitive.length_m;
    }
  }
}

// An emergency stop of the base's own: it must not drive on when somebody releases it later. With
// one wheel held, a line becomes a circle.
TEST(PrimitiveFollower, NoticesAWheelThatIsHeldOnItsWay) {
  constexpr double kPeriod_s = 0.05;
  for (const auto& [left_too, right_too] : {std::pair{true, true}, {true, false}, {false, true}}) {
    for (const double held_s : {2.5, 3.5}) {
      LateWheels wheels(2);
      PrimitiveFollower follower({0.0, 2.0}, kLimits, {});
      WheelSpeeds command;
      WheelDisplacement travelled;
      while (travelled.right_m < 0.5) {
        command = follower.steer(travelled, command, kPeriod_s);
        travelled = wheels.drive(command, kPeriod_s);
      }
      for (double time_s = 0.0; time_s < held_s; time_s += kPeriod_s) {
        command = follower.steer(travelled, command, kPeriod_s);
        if (!left_too) travelled.left_m += kPeriod_s * command.left_mps;
        if (!right_too) travelled.right_m += kPeriod_s * command.right_mps;
      }
      EXPECT_EQ(follower.isDisobeyed(travelled), held_s > 3.0) << left_too << right_too;
    }
  }
}

// Whose motors do not turn for less than a tenth of a metre per second: four times what the end of
// each part asks for.
TEST(PrimitiveFollower, ArrivesWithStiffWheels) {
  constexpr double kPeriod_s = 0.05;
  for (const MotionPrimitive primitive :
       {MotionPrimitive{0.0, 1.0}, MotionPrimitive{-5.0, -0.4}, MotionPrimitive{0.01, 0.03}}) {
    LateWheels wheels(2, 0.1);
    WheelDisplacement travelled;
    PrimitiveFollower follower(primitive, kLimits, travelled);
    WheelSpeeds command;
    for (int steps = 0; !follower.done() && steps < 2000; ++steps) {
      command = follower.steer(travelled, command, kPeriod_s);
      ASSERT_FALSE(follower.isDisobeyed(travelled)) << primitive.length_m;
      travelled = wheels.drive(command, kPeriod_s);
    }
    ASSERT_TRUE(follower.done()) << primitive.turn_rad;
    EXPECT_NEAR(0.5 * (travelled.right_m + travelled.left_m), primitive.length_m, 0.021);
    EXPECT_NEAR(0.5 * (travelled.right_m - travelled.left_m),
                turningWheels(primitive, kSeparation_m).right_m, 0.021);
  }
}

const auto kAnything = [](const MotionPrimitive&) { return true; };

TEST(DriveScript, IsThePapersDance) {
  for (const DriveMotion motion : {DriveMotion::kDance, DriveMotion::kCornerLight}) {
    DriveScript dance(motion);
    for (int i = 0; i < 10; ++i) {
      const auto primitive = dance.next(std::max(0, i - 1) * 2.5 * kPi, kAnything);
      EXPECT_NEAR(primitive->turn_rad, i == 0 ? 0.0 : 2.5 * kPi, 1e-12);
      EXPECT_DOUBLE_EQ(primitive->length_m, 1.0);
    }
  }
}

TEST(DriveMotion, HasANameAndWords) {
  for (const std::string& name : motionNames()) {
    ASSERT_TRUE(motionNamed(name));
    EXPECT_EQ(motionNames().at(static_cast<std::size_t>(*motionNamed(name))), name);
    EXPECT_FALSE(instructionsFor(*motionNamed(name)).empty());
  }
  EXPECT_FALSE(motionNamed("waltz"));
}

TEST(DriveScript, MakesUpForWhatATurnHasMissed) {
  DriveScript dance(DriveMotion::kDance);
  dance.next(0.0, kAnything);
  EXPECT_DOUBLE_EQ(dance.next(0.0, kAnything)->turn_rad, 2.5 * kPi);
  EXPECT_DOUBLE_EQ(dance.next(2.5 * kPi - 0.02, kAnything)->turn_rad, 2.5 * kPi + 0.02);
  // when something else was driven meanwhile, it goes on from there
  EXPECT_DOUBLE_EQ(dance.next(-1.0, kAnything)->turn_rad, 2.5 * kPi);
}

// A goal may replace another one in mid-spin: what the robot turns while it brakes is not made up
// for.
TEST(DriveScript, BeginsAsTheRobotStands) {
  DriveScript dance(DriveMotion::kDance);
  EXPECT_EQ(dance.next(0.4, kAnything)->turn_rad, 0.0);
}

/// Of a Duckiebot whose readings and commands take 0.3 s: each turn leads some 57 deg too far.
TEST(DriveScript, StaysASquareOnASmallRobotWithLateReadings) {
  constexpr double kPeriod_s = 0.05;
  constexpr double kMissed_rad = 1.1;  // by one turn, and never more
  const WheelLimits duckiebot{0.1, 0.2, 1.0};
  LateWheels wheels(6);
  WheelDisplacement travelled;
  WheelSpeeds command;
  DriveScript dance(DriveMotion::kDance);
  for (int side = 0; side < 8; ++side) {
    const double turned_rad = (travelled.right_m - travelled.left_m) / duckiebot.wheel_separation_m;
    EXPECT_NEAR(turned_rad, std::max(0, side - 1) * 2.5 * kPi, kMissed_rad) << side;
    PrimitiveFollower follower(*dance.next(turned_rad, kAnything), duckiebot, travelled);
    for (int steps = 0; steps < 2000 && !follower.done(); ++steps) {
      ASSERT_FALSE(follower.isDisobeyed(travelled)) << side;
      command = follower.steer(travelled, command, kPeriod_s);
      travelled = wheels.drive(command, kPeriod_s);
    }
  }
}

TEST(DriveScript, AnOpeningTurnsToWhereThereIsRoom) {
  const auto backwards_only = [](const MotionPrimitive& primitive) {
    return std::cos(primitive.turn_rad) < -0.9;
  };
  DriveScript opening(DriveMotion::kOptimal);
  opening.next(0.0, kAnything);  // a spin
  EXPECT_DOUBLE_EQ(opening.next(2.0 * kPi, backwards_only)->turn_rad, kPi);
  EXPECT_DOUBLE_EQ(opening.next(3.0 * kPi, kAnything)->turn_rad, 2.0 * kPi);
  const auto short_ways_only = [](const MotionPrimitive& primitive) {
    return primitive.length_m < 0.6;
  };
  EXPECT_DOUBLE_EQ(opening.next(5.0 * kPi, short_ways_only)->length_m, 0.5);
  DriveScript dance(DriveMotion::kDance);
  EXPECT_FALSE(dance.next(0.0, short_ways_only));
}

}  // namespace
}  // namespace bearing_calibration::core
