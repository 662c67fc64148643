#include "bearing_calibration/simulation/trajectory.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bearing_calibration/simulation/random_numbers.h"

namespace bearing_calibration::core {
namespace {

WheelDisplacement wheelsFromMotion(double distance_m, double turn_rad, double wheel_separation_m) {
  return {distance_m - 0.5 * wheel_separation_m * turn_rad,
          distance_m + 0.5 * wheel_separation_m * turn_rad};
}

Trajectory sinusoid(const TrajectoryConfig& config, double wheel_separation_m) {
  const auto heading = [config](double time_s) {
    return config.sinusoid_amplitude_rad * std::sin(2.0 * kPi * time_s / config.sinusoid_period_s);
  };
  return [=, time_s = 0.0](double step_s) mutable {
    const double turn_rad = heading(time_s + step_s) - heading(time_s);
    time_s += step_s;
    return wheelsFromMotion(config.wheel_speed_mps * step_s, turn_rad, wheel_separation_m);
  };
}

Trajectory randomSteps(const TrajectoryConfig& config) {
  RandomStream stream(config.seed, RandomStream::Purpose::kTrajectory);
  return [config, stream](double step_s) mutable {
    const double mean_m = config.wheel_speed_mps * step_s;
    const double stddev_m = std::sqrt(config.random_variance_m * std::abs(mean_m));
    const double left_m = mean_m + stddev_m * stream.gaussian();
    return WheelDisplacement{left_m, mean_m + stddev_m * stream.gaussian()};
  };
}

DriveSegment straight(double length_m, double speed_mps) {
  const double signed_speed_mps = std::copysign(speed_mps, length_m);
  return {signed_speed_mps, signed_speed_mps, std::abs(length_m) / speed_mps};
}

/// Once round to the left, the right wheel being the faster one.
DriveSegment circle(double radius_m, double speed_mps, double wheel_separation_m) {
  const double outer_m = radius_m + 0.5 * wheel_separation_m;
  const double inner_m = radius_m - 0.5 * wheel_separation_m;
  return {speed_mps * inner_m / outer_m, speed_mps, 2.0 * kPi * outer_m / speed_mps};
}

}  // namespace

Trajectory segmentTrajectory(std::vector<DriveSegment> segments) {
  if (segments.empty()) throw std::invalid_argument("a trajectory needs at least one segment");
  for (const DriveSegment& segment : segments) {
    if (!(segment.duration_s > 0.0)) throw std::invalid_argument("a segment must last some time");
  }
  const double first_s = segments.front().duration_s;
  return [segments = std::move(segments), current = std::size_t{0},
          left_in_segment_s = first_s](double step_s) mutable {
    WheelDisplacement wheels;
    while (step_s > 0.0) {
      const DriveSegment& segment = segments[current];
      const double time_s = std::min(step_s, left_in_segment_s);
      wheels.left_m += segment.left_mps * time_s;
      wheels.right_m += segment.right_mps * time_s;
      step_s -= time_s;
      left_in_segment_s -= time_s;
      if (left_in_segment_s <= 0.0) {
        current = (current + 1) % segments.size();
        left_in_segment_s = segments[current].duration_s;
      }
    }
    return wheels;
  };
}

Trajectory limitedTrajectory(Trajectory trajectory, double duration_s) {
  return [trajectory = std::move(trajectory), left_s = duration_s](double step_s) mutable {
    const double time_s = std::min(step_s, left_s);
    left_s -= time_s;
    return time_s > 0.0 ? trajectory(time_s) : WheelDisplacement{};
  };
}

CommandedTrajectory::CommandedTrajectory(double wheel_separation_m, double max_wheel_speed_mps,
                                         double timeout_s)
    : wheel_separation_m_(wheel_separation_m),
      max_wheel_speed_mps_(max_wheel_speed_mps),
      timeout_s_(timeout_s) {}

void CommandedTrajectory::command(double forward_mps, double turn_radps) {
  if (!std::isfinite(forward_mps) || !std::isfinite(turn_radps)) {
    throw std::invalid_argument("a velocity command must be finite");
  }
  const WheelDisplacement speed = wheelsFromMotion(forward_mps, turn_radps, wheel_separation_m_);
  const double fastest = std::max(std::abs(speed.left_m), std::abs(speed.right_m));
  const double factor = fastest > max_wheel_speed_mps_ ? max_wheel_speed_mps_ / fastest : 1.0;
  command_ = {factor * speed.left_m, factor * speed.right_m, timeout_s_};
}

WheelDisplacement CommandedTrajectory::advance(double step_s) {
  const double time_s = std::min(step_s, command_.duration_s);
  command_.duration_s -= time_s;
  return {command_.left_mps * time_s, command_.right_mps * time_s};
}

void TrajectoryConfig::declare(Parameters& params) {
  using namespace plausible;
  constexpr double kMostTurns_rad = 1000.0;
  constexpr double kNoisiest_m = 1.0;  // a metre off after a metre
  params.number("trajectory/wheel_speed", wheel_speed_mps, kSlowest_mps, kFastest_mps);
  params.number("trajectory/segment_length", segment_length_m, kShortest_m, kFarthest_m);
  params.number("trajectory/dance_turn", dance_turn_rad, kLeastAngle_rad, kMostTurns_rad);
  params.number("trajectory/circle_radius", circle_radius_m, kShortest_m, kFarthest_m);
  params.number("trajectory/sinusoid_amplitude", sinusoid_amplitude_rad, 0.0, kMostTurns_rad);
  params.number("trajectory/sinusoid_period", sinusoid_period_s, kBriefest_s, kLongest_s);
  params.number("trajectory/random_variance", random_variance_m, 0.0, kNoisiest_m);
}

const std::vector<std::string>& trajectoryNames() {
  static const std::vector<std::string> names = {"dance",          "turns",    "sinusoid",
                                                 "random",         "standing", "line",
                                                 "back_and_forth", "circle",   "spin"};
  return names;
}

Trajectory makeTrajectory(const TrajectoryConfig& config, double wheel_separation_m) {
  validated(config);
  if (!(wheel_separation_m > 0.0)) {
    throw std::invalid_argument("the wheel separation must be greater than 0");
  }
  using Kind = TrajectoryConfig::Kind;
  const double speed_mps = config.wheel_speed_mps;
  const DriveSegment ahead = straight(config.segment_length_m, speed_mps);
  const auto spin = [&](double angle_rad) {  // to the left on the spot
    return DriveSegment{-speed_mps, speed_mps, 0.5 * wheel_separation_m * angle_rad / speed_mps};
  };
  switch (config.kind) {
    case Kind::kDance:
      return segmentTrajectory({ahead, spin(config.dance_turn_rad)});
    case Kind::kTurns:
      return segmentTrajectory({ahead, spin(0.5 * kPi)});
    case Kind::kSinusoid:
      return sinusoid(config, wheel_separation_m);
    case Kind::kRandom:
      return randomSteps(config);
    case Kind::kLine:
      return segmentTrajectory({ahead});
    case Kind::kBackAndForth:
      return segmentTrajectory({ahead, straight(-config.segment_length_m, speed_mps)});
    case Kind::kCircle:
      return segmentTrajectory({circle(config.circle_radius_m, speed_mps, wheel_separation_m)});
    case Kind::kSpin:
      return segmentTrajectory({spin(2.0 * kPi)});
    case Kind::kStanding:
      break;
  }
  return [](double) { return WheelDisplacement{}; };
}

}  // namespace bearing_calibration::core
