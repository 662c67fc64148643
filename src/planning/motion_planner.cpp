#include "bearing_calibration/planning/motion_planner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

/// How many of the best first primitives are followed further.
constexpr std::size_t kBeam = 6;
/// Aim so much farther from the light than allowed, so that a primitive's rounding does not forbid
/// it.
constexpr double kSpare_m = 0.005;
constexpr double kShortestPrimitive_m = 0.05;  // shorter ways teach less than their ramps cost
/// A side of the polygon about the light that the best drives known are made of (doc/driving.md).
constexpr double kChord_m = 0.4;

/// All ways to turn so that the base then goes along `course_rad`, forward or backwards.
void addTurns(double course_rad, double length_m, std::vector<MotionPrimitive>* primitives) {
  for (const double sense : {1.0, -1.0}) {
    const double turn = wrapAngle(sense > 0.0 ? course_rad : course_rad + kPi);
    const double other_way_round = turn - std::copysign(2.0 * kPi, turn);
    primitives->push_back({turn, sense * length_m});
    primitives->push_back({other_way_round, sense * length_m});
  }
}

}  // namespace

void PlannerConfig::declare(Parameters& params) {
  using plausible::kFarthest_m;
  params.choice("planner/block", {"mount", "position", "yaw"}, block);
  params.number("planner/light_distance", light_distance_m, plausible::kShortest_m, kFarthest_m);
  params.number("planner/light_sigmas", light_sigmas, 0.0, plausible::kMostSigmas);
  params.number("planner/region_margin", region_margin_m, 0.0, kFarthest_m);
  params.number("planner/max_straight", max_straight_m, 2.0 * kShortestPrimitive_m, kFarthest_m);
}

Pose2 poseAfter(const MotionPrimitive& primitive, const Pose2& frame_from_base) {
  const Pose2 turned{frame_from_base.position_m,
                     wrapAngle(frame_from_base.yaw_rad + primitive.turn_rad)};
  return turned * Pose2{{primitive.length_m, 0.0}, 0.0};
}

/// A primitive, where it leads, and what it brings.
struct MotionPlanner::Candidate {
  MotionPrimitive primitive;
  RobotEstimate expected;
  Pose2 start_from_base;
  double duration_s = 0.0;
  double gain = 0.0;  ///< by how much the log det falls
  double rate() const { return gain / duration_s; }
};

MotionPlanner::MotionPlanner(const PlannerConfig& config, const WheelLimits& limits,
                             const SensingModel& sensing, const Region& region)
    : config_(validated(config)),
      limits_(validated(limits)),
      sensing_(validated(sensing)),
      region_(validated(region)) {}

double MotionPlanner::logDet(const CartesianEstimate& estimate) const {
  const auto log_det = [](const auto& covariance) {
    return 2.0 * covariance.llt().matrixLLT().diagonal().array().log().sum();
  };
  switch (config_.block) {
    case PlannerConfig::Block::kMount:
      return log_det(Eigen::Matrix3d(estimate.covariance.bottomRightCorner<3, 3>()));
    case PlannerConfig::Block::kPosition:
      return log_det(Eigen::Matrix2d(estimate.covariance.block<2, 2>(2, 2)));
    case PlannerConfig::Block::kYaw:
      break;
  }
  return std::log(estimate.covariance(CartesianIndex::kSensorYaw, CartesianIndex::kSensorYaw));
}

bool MotionPlanner::staysInside(const MotionPrimitive& primitive,
                                const Pose2& start_from_base) const {
  const Eigen::Vector2d& from = start_from_base.position_m;
  const double needed_m = std::min(config_.region_margin_m, region_.clearance(from));
  return region_.clearance(from, poseAfter(primitive, start_from_base).position_m) >= needed_m;
}

bool MotionPlanner::keepsAway(const MotionPrimitive& primitive,
                              const CartesianEstimate& estimate) const {
  const double here_m = lightClearance({}, estimate, config_.light_sigmas);
  const double needed_m = std::min(config_.light_distance_m, here_m);
  return lightClearance(primitive, estimate, config_.light_sigmas) >= needed_m;
}

bool MotionPlanner::isSurelyTooNear(const MotionPrimitive& primitive,
                                    const CartesianEstimate& estimate) const {
  const double here_m = lightClearance({}, estimate, -config_.light_sigmas);
  const double needed_m = std::min(config_.light_distance_m, here_m);
  return lightClearance(primitive, estimate, -config_.light_sigmas) < needed_m;
}

/// Courses by where the light is: chords that pass it as near as allowed, a way straight to the
/// nearest place allowed, and ways past and away from it.
std::vector<MotionPrimitive> MotionPlanner::proposals(const CartesianEstimate& estimate) const {
  const Eigen::Vector2d light = estimate.lightInBase();
  const double distance_m = light.norm();
  const double to_light_rad = std::atan2(light.y(), light.x());
  const double sigmas_m = distance_m - lightClearance({}, estimate, config_.light_sigmas);
  const double limit_m = config_.light_distance_m + sigmas_m + kSpare_m;
  const double tangent_rad = std::asin(std::min(1.0, limit_m / distance_m));
  const double to_tangent_m = distance_m * std::cos(tangent_rad);

  std::vector<MotionPrimitive> primitives;
  const auto add = [&](double from_light_rad, double length_m) {
    const double length = std::min(length_m, config_.max_straight_m);
    if (length >= kShortestPrimitive_m)
      addTurns(to_light_rad + from_light_rad, length, &primitives);
  };
  const double half_m = 0.5 * config_.max_straight_m;
  const double approach_m = distance_m - limit_m;
  add(0.0, approach_m);
  if (approach_m > half_m) add(0.0, half_m);
  for (const double side : {1.0, -1.0}) {
    add(side * tangent_rad, 2.0 * to_tangent_m);
    if (to_tangent_m < config_.max_straight_m) {
      add(side * tangent_rad, to_tangent_m);
      add(side * tangent_rad, to_tangent_m + 0.5 * kChord_m);
    }
    add(side * 0.5 * (tangent_rad + 0.5 * kPi), half_m);
    add(side * 0.5 * kPi, half_m);
  }
  add(kPi, half_m);
  return primitives;
}

std::vector<MotionPlanner::Candidate> MotionPlanner::candidatesAt(
    const RobotEstimate& estimate, const Pose2& start_from_base) const {
  const double log_det = logDet(estimate.cartesian);
  std::vector<Candidate> candidates;
  for (const MotionPrimitive& proposal : proposals(estimate.cartesian)) {
    // judged as it will be driven: without a small turn a way may pass nearer to the light
    const MotionPrimitive primitive = driveable(proposal, limits_.wheel_separation_m);
    if (!keepsAway(primitive, estimate.cartesian) || !staysInside(primitive, start_from_base))
      continue;
    Candidate candidate{primitive, predictAfter(primitive, estimate, limits_, sensing_),
                        poseAfter(primitive, start_from_base), durationOf(primitive, limits_), 0.0};
    candidate.gain = log_det - logDet(candidate.expected.cartesian);
    if (std::isfinite(candidate.gain)) candidates.push_back(candidate);
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.rate() > b.rate(); });
  return candidates;
}

std::optional<PlannedPrimitive> MotionPlanner::plan(const RobotEstimate& estimate,
                                                    const Pose2& start_from_base) const {
  const std::vector<Candidate> firsts = candidatesAt(estimate, start_from_base);
  if (firsts.empty()) return std::nullopt;
  PlannedPrimitive best{firsts.front().primitive, {}, firsts.front().expected};
  double best_rate = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(kBeam, firsts.size()); ++i) {
    const Candidate& first = firsts[i];
    for (const Candidate& second : candidatesAt(first.expected, first.start_from_base)) {
      // Pairs are compared with pairs: a short primitive that gains much at once may end where
      // nothing more is to be gained.
      const double rate = (first.gain + second.gain) / (first.duration_s + second.duration_s);
      if (rate <= best_rate) continue;
      best_rate = rate;
      best = {first.primitive, second.primitive, second.expected};
    }
  }
  return best;
}

}  // namespace bearing_calibration::core
