#include "bearing_calibration/planning/motion_planner.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/motion_model.h"

namespace bearing_calibration::core {
namespace {

/// How many of the best first primitives are followed further.
constexpr std::size_t kBeam = 6;
/// Aim so much farther from the light than allowed, so that a primitive's rounding does not forbid
/// it.
constexpr double kSpare_m = 0.005;
constexpr double kShortestPrimitive_m = 0.05;  // shorter ways teach less than their ramps cost
/// A side of the polygon about the light that the best drives known are made of (driving.md).
constexpr double kChord_m = 0.4;

constexpr double kLongestStep_s = 0.25;  // 0.4 rad of a spin at 0.2 m/s: information hardly varies
/// ... and where the sensor sees a part of a turn only, a step turns by at most so much of it.
constexpr double kMostOfView = 0.125;
/// However narrow the view or slow the wheels: a plan tries hundreds of ways, and commands wait.
constexpr double kMostSteps = 1000.0;
/// Fewer bearings of a step teach nothing.
constexpr double kFewestBearings = 1e-3;
constexpr double kSameStep = 1e-9;  // of a part of the way: rounding

/// All ways to turn so that the base then goes along `course_rad`, forward or backwards.
void addTurns(double course_rad, double length_m, std::vector<MotionPrimitive>* primitives) {
  for (const double sense : {1.0, -1.0}) {
    const double turn = wrapAngle(sense > 0.0 ? course_rad : course_rad + kPi);
    const double other_way_round = turn - std::copysign(2.0 * kPi, turn);
    primitives->push_back({turn, sense * length_m});
    primitives->push_back({other_way_round, sense * length_m});
  }
}

/// Travel around a moment of wheels that keep their speed.
OdometryWindow steadyTravel(const WheelSpeeds& speeds, double wheel_separation_m) {
  std::array<WheelDisplacement, OdometryWindow::kSamples> samples;
  double time_s = 0.0;
  for (WheelDisplacement& sample : samples) {
    sample = {time_s * speeds.left_mps, time_s * speeds.right_mps};
    time_s += OdometryWindow::kStep_s;
  }
  return {samples, wheel_separation_m};
}

int stepsOf(const WheelDisplacement& wheels, double duration_s, const WheelLimits& limits,
            const FieldOfView& view) {
  double steps = duration_s / kLongestStep_s;
  if (view.isLimited()) {
    const double turn_rad = (wheels.right_m - wheels.left_m) / limits.wheel_separation_m;
    steps = std::max(steps, std::abs(turn_rad) / (kMostOfView * view.width_rad));
  }
  return static_cast<int>(std::ceil(std::min(steps, kMostSteps)));
}

/// Lets the wheels roll from standstill to standstill.
void follow(const WheelDisplacement& wheels, const WheelLimits& limits, const SensingModel& sensing,
            StateEstimate* estimate) {
  const double duration_s = travelTime(wheels.right_m, limits);
  const int steps = stepsOf(wheels, duration_s, limits, sensing.view);
  double done = 0.0;
  double last_part = 0.0;
  OdometryIncrement motion;
  OdometryWindow nearby;
  double chance_before = chanceInView(sensing.view, *estimate);
  for (int i = 1; i <= steps; ++i) {
    const double step_s = duration_s / steps;
    const double share = travelAt(i * step_s, wheels.right_m, limits) / wheels.right_m;
    const double part = share - done;
    done = share;
    if (std::abs(part - last_part) > kSameStep) {  // at full speed one step is like the last
      const WheelDisplacement rolled{part * wheels.left_m, part * wheels.right_m};
      motion = append({}, rolled, limits.wheel_separation_m, sensing.wheel_noise);
      nearby = steadyTravel({rolled.left_m / step_s, rolled.right_m / step_s},
                            limits.wheel_separation_m);
      last_part = part;
    }
    propagate(motion, estimate);
    const double chance = chanceInView(sensing.view, *estimate, nearby);
    const double bearings = 0.5 * (chance_before + chance) * (step_s * sensing.bearing_rate_hz);
    chance_before = chance;
    if (bearings < kFewestBearings) continue;
    const ExpectedAngle azimuth = expectAzimuth(estimate->layout, estimate->mean, 0, nearby);
    constexpr double kAsExpected = 0.0;
    apply(prepareUpdate(azimuth.J_angle_state, kAsExpected,
                        std::pow(sensing.bearing_stddev_rad, 2) / bearings, *estimate),
          estimate);
  }
}

}  // namespace

void SensingModel::declare(Parameters& params) {
  wheel_noise.declare(params);
  params.number("planner/bearing_stddev", bearing_stddev_rad, plausible::kLeastAngle_rad,
                plausible::kTurn_rad);
  params.number("planner/bearing_rate", bearing_rate_hz, plausible::kRarest_hz,
                plausible::kMostFrequent_hz);
}

void PlannerConfig::declare(Parameters& params) {
  using plausible::kFarthest_m;
  params.choice("planner/block", {"mount", "position", "yaw"}, block);
  params.number("planner/light_distance", light_distance_m, plausible::kShortest_m, kFarthest_m);
  params.number("planner/light_sigmas", light_sigmas, 0.0, plausible::kMostSigmas);
  params.number("planner/region_margin", region_margin_m, 0.0, kFarthest_m);
  params.number("planner/max_straight", max_straight_m, 2.0 * kShortestPrimitive_m, kFarthest_m);
}

StateEstimate predictAfter(const MotionPrimitive& primitive, StateEstimate estimate,
                           const WheelLimits& limits, const SensingModel& sensing) {
  follow(turningWheels(primitive, limits.wheel_separation_m), limits, sensing, &estimate);
  follow(straightWheels(primitive), limits, sensing, &estimate);
  return estimate;
}

double chanceInView(const FieldOfView& view, const StateEstimate& estimate,
                    const OdometryWindow& nearby) {
  if (!view.isLimited()) return 1.0;
  const ExpectedAngle azimuth = expectAzimuth(estimate.layout, estimate.mean, 0, nearby);
  const StateRow& H = azimuth.J_angle_state;
  const double variance = (H * estimate.covariance).dot(H);
  return view.chanceOf(azimuth.angle_rad, std::sqrt(std::max(0.0, variance)));
}

double lightClearance(const MotionPrimitive& primitive, const StateEstimate& estimate,
                      double sigmas, int light) {
  const int at = estimate.layout.lightAt(light);
  const Eigen::Vector2d light_m = estimate.mean.segment<2>(at);
  const Eigen::Vector2d course(std::cos(primitive.turn_rad), std::sin(primitive.turn_rad));
  const double nearest_m = std::clamp(course.dot(light_m), std::min(0.0, primitive.length_m),
                                      std::max(0.0, primitive.length_m));
  const Eigen::Vector2d to_light = light_m - nearest_m * course;
  const double distance_m = to_light.norm();
  if (distance_m <= 0.0) return 0.0;
  const Eigen::Vector2d direction = to_light / distance_m;
  const Eigen::Matrix2d covariance = estimate.covariance.block<2, 2>(at, at);
  return distance_m - sigmas * std::sqrt(direction.dot(covariance * direction));
}

StateEstimate withLight(const StateEstimate& estimate, const Eigen::Vector2d& light_m,
                        const Eigen::Matrix2d& covariance) {
  StateEstimate more = StateEstimate::zero({estimate.layout.errors, estimate.layout.lights + 1});
  const int size = estimate.layout.size();
  more.mean << estimate.mean, light_m;
  more.covariance.topLeftCorner(size, size) = estimate.covariance;
  more.covariance.bottomRightCorner<2, 2>() = covariance;
  return more;
}

struct MotionPlanner::Candidate {
  MotionPrimitive primitive;
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

double MotionPlanner::logDet(const StateEstimate& estimate) const {
  const Eigen::Matrix3d mount = mountOf(estimate).covariance;
  if (config_.block == PlannerConfig::Block::kMount) return std::log(mount.determinant());
  if (config_.block == PlannerConfig::Block::kYaw) return std::log(mount(2, 2));
  return std::log(mount.topLeftCorner<2, 2>().determinant());
}

bool MotionPlanner::staysInside(const MotionPrimitive& primitive,
                                const Pose2& start_from_base) const {
  const Eigen::Vector2d& from = start_from_base.position_m;
  const double needed_m = std::min(config_.region_margin_m, region_.clearance(from));
  return region_.clearance(from, poseAfter(primitive, start_from_base).position_m) >= needed_m;
}

bool MotionPlanner::keepsAway(const MotionPrimitive& primitive, const StateEstimate& estimate,
                              bool is_asked_for) const {
  const auto isKept = [&](int light, double sigmas) {
    const double here_m = lightClearance({}, estimate, sigmas, light);
    return lightClearance(primitive, estimate, sigmas, light) >=
           std::min(config_.light_distance_m, here_m);
  };
  for (int light = 0; light < estimate.layout.lights; ++light) {
    const double sigmas = is_asked_for ? -config_.light_sigmas : config_.light_sigmas;
    // Of the others one that may stand anywhere would bar every way.
    const bool is_vague =
        light > 0 && !is_asked_for && lightClearance({}, estimate, sigmas, light) <= 0.0;
    if (!is_vague && !isKept(light, sigmas)) return false;
    // A light that may be anywhere is kept away from where it most probably is, at least.
    if (!is_asked_for && !isKept(light, 0.0)) return false;
  }
  return true;
}

/// Courses by where the light is: chords that pass it as near as allowed, a way straight to the
/// nearest place allowed, and ways past and away from it.
std::vector<MotionPrimitive> MotionPlanner::proposals(const StateEstimate& estimate) const {
  const Eigen::Vector2d light = estimate.mean.segment<2>(estimate.layout.lightAt(0));
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
    const StateEstimate& estimate, const Pose2& start_from_base) const {
  const double log_det = logDet(estimate);
  std::vector<Candidate> candidates;
  for (const MotionPrimitive& proposal : proposals(estimate)) {
    // judged as it will be driven: without a small turn a way may pass nearer to the light
    const MotionPrimitive primitive = driveable(proposal, limits_.wheel_separation_m);
    if (!keepsAway(primitive, estimate) || !staysInside(primitive, start_from_base)) continue;
    const double gain = log_det - logDet(after(primitive, estimate));
    if (std::isfinite(gain))
      candidates.push_back({primitive, durationOf(primitive, limits_), gain});
  }
  return candidates;
}

std::optional<PlannedPrimitive> MotionPlanner::plan(const StateEstimate& estimate,
                                                    const Pose2& start_from_base) const {
  std::vector<Candidate> firsts = candidatesAt(estimate, start_from_base);
  if (firsts.empty()) return std::nullopt;
  std::sort(firsts.begin(), firsts.end(),
            [](const Candidate& a, const Candidate& b) { return a.rate() > b.rate(); });
  firsts.resize(std::min(kBeam, firsts.size()));
  PlannedPrimitive best{firsts.front().primitive, {}, {}};
  double best_rate = -std::numeric_limits<double>::infinity();
  for (const Candidate& first : firsts) {
    for (const Candidate& second : candidatesAt(after(first.primitive, estimate),
                                                poseAfter(first.primitive, start_from_base))) {
      // Pairs are compared with pairs: a short primitive that gains much at once may end where
      // nothing more is to be gained.
      const double rate = (first.gain + second.gain) / (first.duration_s + second.duration_s);
      if (rate <= best_rate) continue;
      best_rate = rate;
      best.primitive = first.primitive;
      best.next = second.primitive;
    }
  }
  best.expected = mountOf(after(best.next, after(best.primitive, estimate)));
  return best;
}

}  // namespace bearing_calibration::core
