#include "bearing_calibration/simulation/trajectory_config.h"

#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

DriveSegment straight(double length_m, double speed_mps) {
  const double signed_speed_mps = std::copysign(speed_mps, length_m);
  return {signed_speed_mps, signed_speed_mps, std::abs(length_m) / speed_mps};
}

/// To the left on the spot.
DriveSegment spin(double angle_rad, double speed_mps, double wheel_separation_m) {
  return {-speed_mps, speed_mps, 0.5 * wheel_separation_m * angle_rad / speed_mps};
}

/// Once round to the left, the right wheel being the faster one.
DriveSegment circle(double radius_m, double speed_mps, double wheel_separation_m) {
  const double outer_m = radius_m + 0.5 * wheel_separation_m;
  const double inner_m = radius_m - 0.5 * wheel_separation_m;
  return {speed_mps * inner_m / outer_m, speed_mps, 2.0 * kPi * outer_m / speed_mps};
}

std::vector<DriveSegment> segmentsOf(const TrajectoryConfig& config, double wheel_separation_m) {
  using Kind = TrajectoryConfig::Kind;
  const double speed_mps = config.wheel_speed_mps;
  const double length_m = config.segment_length_m;
  switch (config.kind) {
    case Kind::kDance:
      return {straight(length_m, speed_mps),
              spin(config.dance_turn_rad, speed_mps, wheel_separation_m)};
    case Kind::kTurns:
      return {straight(length_m, speed_mps), spin(0.5 * kPi, speed_mps, wheel_separation_m)};
    case Kind::kLine:
      return {straight(length_m, speed_mps)};
    case Kind::kBackAndForth:
      return {straight(length_m, speed_mps), straight(-length_m, speed_mps)};
    case Kind::kCircle:
      return {circle(config.circle_radius_m, speed_mps, wheel_separation_m)};
    case Kind::kSpin:
      return {spin(2.0 * kPi, speed_mps, wheel_separation_m)};
    case Kind::kStanding:
    case Kind::kSinusoid:
    case Kind::kRandom:
      break;
  }
  constexpr DriveSegment kStandStill{0.0, 0.0, 1.0};
  return {kStandStill};
}

}  // namespace

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

std::unique_ptr<Trajectory> makeTrajectory(const TrajectoryConfig& config,
                                           double wheel_separation_m) {
  validated(config);
  if (!(wheel_separation_m > 0.0)) {
    throw std::invalid_argument("the wheel separation must be greater than 0");
  }
  if (config.kind == TrajectoryConfig::Kind::kSinusoid) {
    return std::make_unique<SinusoidTrajectory>(
        SinusoidTrajectory::Config{config.wheel_speed_mps, config.sinusoid_amplitude_rad,
                                   config.sinusoid_period_s},
        wheel_separation_m);
  }
  if (config.kind == TrajectoryConfig::Kind::kRandom) {
    return std::make_unique<RandomTrajectory>(config.wheel_speed_mps, config.random_variance_m,
                                              config.seed);
  }
  return std::make_unique<SegmentTrajectory>(segmentsOf(config, wheel_separation_m));
}

}  // namespace bearing_calibration::core
