#include "tools/study/best_drive.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace bearing_calibration::core {
namespace {

/// So little is known before the drive: the bound is that of the drive alone.
constexpr double kIgnorance = 100.0;

StateEstimate truthOf(const DrivenCase& driven) {
  const RobotConfig& robot = driven.simulated.robot;
  CartesianEstimate truth;
  truth.mean << robot.world_from_start.inverse() * driven.simulated.lights.front().position_m,
      robot.base_from_sensor.position_m, robot.base_from_sensor.yaw_rad;
  truth.covariance = kIgnorance * Matrix5::Identity();
  return StateEstimate::of(truth);
}

/// The part of a primitive that can be driven in `time_s`.
MotionPrimitive cutTo(const MotionPrimitive& primitive, double time_s, const WheelLimits& limits) {
  constexpr int kHalvings = 30;
  const auto part = [&primitive](double share) {  // the first half of the shares turns
    return MotionPrimitive{primitive.turn_rad * std::min(1.0, 2.0 * share),
                           primitive.length_m * std::max(0.0, 2.0 * share - 1.0)};
  };
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (durationOf(part(middle), limits) > time_s ? high : low) = middle;
  }
  return part(low);
}

class Search {
 public:
  Search(const DrivenCase& driven, double duration_s, std::uint64_t seed)
      : driven_(driven), duration_s_(duration_s), truth_(truthOf(driven)), engine_(seed) {
    // Room for one more primitive than fits, so that a change that saves time finds something to
    // do.
    constexpr double kMargin_s = 20.0;
    best_cost_ = std::numeric_limits<double>::infinity();
    consider(evaluated(plannedPrimitives(duration_s + kMargin_s)));
    for (const double chord_m : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2}) {
      for (const int turns : {-2, -1, 0, 1}) {
        consider(evaluated(polygonPrimitives(chord_m, turns, duration_s + kMargin_s)));
      }
    }
  }

  BestDrive run(int changes) {
    for (int i = 0; i < changes; ++i) {
      // changes of all sizes, the smaller ones towards the end
      const double size = std::pow(10.0, -2.0 * uniform() * i / changes);
      consider(evaluated(changed(size)));
    }
    return best_;
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine_); }
  double gaussian(double stddev) { return std::normal_distribution<double>(0.0, stddev)(engine_); }
  std::size_t index(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(engine_);
  }

  std::vector<MotionPrimitive> plannedPrimitives(double until_s) const {
    const DriveConfig& drive = driven_.drive;
    PlannerConfig config = drive.planner;
    config.light_sigmas = 0.0;  // the light is known here
    const MotionPlanner planner(config, drive.limits, drive.sensing, drive.region);
    std::vector<MotionPrimitive> primitives;
    StateEstimate estimate = truth_;
    Pose2 start_from_base;
    for (double time_s = 0.0; time_s < until_s;
         time_s += durationOf(primitives.back(), drive.limits)) {
      const auto plan = planner.plan(estimate, start_from_base);
      if (!plan) break;
      primitives.push_back(plan->primitive);
      estimate = predictAfter(plan->primitive, estimate, drive.limits, drive.sensing);
      start_from_base = poseAfter(plan->primitive, start_from_base);
    }
    return primitives;
  }

  void consider(BestDrive candidate) {
    const double cost = costOf(candidate);
    if (cost >= best_cost_) return;
    best_ = std::move(candidate);
    best_cost_ = cost;
  }

  /// Straight to the nearest place allowed, passing the light on the left; from there on a regular
  /// polygon about it with so many full turns at each corner beside its own.
  std::vector<MotionPrimitive> polygonPrimitives(double chord_m, int turns, double until_s) const {
    constexpr double kSpare_m = 1e-4;
    const double inner_m = driven_.drive.planner.light_distance_m + kSpare_m;
    const Eigen::Vector2d light = truth_.mean.tail<2>();
    const double to_tangent_m = std::sqrt(light.squaredNorm() - inner_m * inner_m);
    std::vector<MotionPrimitive> primitives{
        {std::atan2(light.y(), light.x()) - std::asin(inner_m / light.norm()),
         to_tangent_m + 0.5 * chord_m}};
    const MotionPrimitive corner{2.0 * std::atan(0.5 * chord_m / inner_m) + 2.0 * kPi * turns,
                                 chord_m};
    const double corner_s = durationOf(corner, driven_.drive.limits);
    for (double time_s = 0.0; time_s < until_s; time_s += corner_s) primitives.push_back(corner);
    return primitives;
  }

  BestDrive evaluated(std::vector<MotionPrimitive> primitives) const {
    const DriveConfig& drive = driven_.drive;
    BestDrive result{std::move(primitives), {}, std::numeric_limits<double>::infinity()};
    StateEstimate estimate = truth_;
    double left_s = duration_s_;
    for (const MotionPrimitive& primitive : result.primitives) {
      if (left_s <= 0.0) break;
      const double needed_s = durationOf(primitive, drive.limits);
      const MotionPrimitive driveable =
          needed_s <= left_s ? primitive : cutTo(primitive, left_s, drive.limits);
      left_s -= needed_s;
      result.least_distance_m =
          std::min(result.least_distance_m, lightClearance(driveable, estimate, 0.0));
      estimate = predictAfter(driveable, estimate, drive.limits, drive.sensing);
    }
    result.mount_covariance = estimate.mount().covariance;
    return result;
  }

  double costOf(const BestDrive& candidate) const {
    if (candidate.least_distance_m < driven_.drive.planner.light_distance_m) {
      return std::numeric_limits<double>::infinity();
    }
    return candidate.mount_covariance.determinant();
  }

  /// Another drive: one primitive turned or made longer, with or without what follows turning
  /// along.
  std::vector<MotionPrimitive> changed(double size) {
    constexpr double kTurnStddev = 1.0;
    constexpr double kLengthStddev_m = 0.5;
    std::vector<MotionPrimitive> primitives = best_.primitives;
    const std::size_t i = index(primitives.size());
    switch (index(5)) {
      case 0:
        primitives[i].turn_rad += gaussian(kTurnStddev * size);
        break;
      case 1: {
        const double turn = gaussian(kTurnStddev * size);
        primitives[i].turn_rad += turn;
        if (i + 1 < primitives.size()) primitives[i + 1].turn_rad -= turn;
        break;
      }
      case 2:
        primitives[i].length_m += gaussian(kLengthStddev_m * size);
        break;
      case 3:
        primitives[i].turn_rad += std::copysign(2.0 * kPi, gaussian(1.0));
        break;
      default:
        if (uniform() < 0.5) {
          primitives.insert(primitives.begin() + static_cast<std::ptrdiff_t>(i),
                            {gaussian(kTurnStddev), gaussian(kLengthStddev_m)});
        } else if (primitives.size() > 1) {
          primitives.erase(primitives.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    return primitives;
  }

  const DrivenCase& driven_;
  double duration_s_;
  StateEstimate truth_;
  std::mt19937_64 engine_;
  BestDrive best_;
  double best_cost_ = 0.0;
};

}  // namespace

BestDrive findBestDrive(const DrivenCase& driven, double duration_s, int changes,
                        std::uint64_t seed) {
  return Search(driven, duration_s, seed).run(changes);
}

}  // namespace bearing_calibration::core
