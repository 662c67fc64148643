#include "tools/study/unmodelled.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "bearing_calibration/common/formatted.h"
#include "tools/study/draws.h"

namespace bearing_calibration::core {
namespace {

/// What the wheels report instead of what they have rolled since the last reading.
using Distortion = std::function<WheelDisplacement(const WheelDisplacement& rolled, double time_s,
                                                   const Pose2& world_from_base)>;

/// As if the wheels were so many times as far apart.
WheelDisplacement farther(const WheelDisplacement& rolled, double factor) {
  const double middle_m = 0.5 * (rolled.left_m + rolled.right_m);
  const double half_m = 0.5 * factor * (rolled.right_m - rolled.left_m);
  return {middle_m - half_m, middle_m + half_m};
}

Distortion swingingSeparation() {
  constexpr double kSwing = 0.03;
  constexpr double kPeriod_s = 37.0;
  return [](const WheelDisplacement& rolled, double time_s, const Pose2&) {
    return farther(rolled, 1.0 + kSwing * std::sin(2.0 * kPi * time_s / kPeriod_s));
  };
}

Distortion senseOfTurn() {
  constexpr double kDifference = 0.015;
  return [](const WheelDisplacement& rolled, double, const Pose2&) {
    const double side = rolled.right_m > rolled.left_m ? 0.5 : -0.5;
    return farther(rolled, 1.0 + side * kDifference);
  };
}

Distortion driftingTyre(double duration_s) {
  constexpr double kDrift = 0.006;
  return [duration_s](const WheelDisplacement& rolled, double time_s, const Pose2&) {
    return WheelDisplacement{(1.0 + kDrift * time_s / duration_s) * rolled.left_m, rolled.right_m};
  };
}

/// Every other stripe of the floor gives the wheels less hold.
Distortion twoGrips(const WheelNoise& noise, std::uint64_t seed) {
  constexpr double kStripe_m = 0.5;
  constexpr double kRoughness = 25.0;  // of the variance
  const double more_k_m = (kRoughness - 1.0) * noise.independent_k_m;
  return [more_k_m, draws = Draws(seed, Draws::Purpose::kUnmodelled)](
             WheelDisplacement rolled, double, const Pose2& world_from_base) mutable {
    const double stripe = std::floor(world_from_base.position_m.y() / kStripe_m);
    if (std::fmod(stripe, 2.0) == 0.0) return rolled;
    rolled.left_m += draws.gaussian(std::sqrt(more_k_m * std::abs(rolled.left_m)));
    rolled.right_m += draws.gaussian(std::sqrt(more_k_m * std::abs(rolled.right_m)));
    return rolled;
  };
}

void distortTicks(const DriveGeometry& drive, const Distortion& reported, SimulatedRecord* record) {
  const WheelCounts first = record->ticks.front();
  WheelCounts last = first;
  WheelDisplacement all_m;
  std::size_t image = 0;
  for (WheelCounts& ticks : record->ticks) {
    while (image + 1 < record->bearings.size() && record->bearings[image + 1].stamp <= ticks.stamp)
      ++image;
    const auto rolled = [](std::int64_t now, std::int64_t before, double meters_per_tick) {
      return meters_per_tick * static_cast<double>(now - before);
    };
    const WheelDisplacement step =
        reported({rolled(ticks.left_ticks, last.left_ticks, drive.leftMetersPerTick()),
                  rolled(ticks.right_ticks, last.right_ticks, drive.rightMetersPerTick())},
                 secondsFromDuration(ticks.stamp - first.stamp), record->world_from_base[image]);
    last = ticks;
    all_m.left_m += step.left_m;
    all_m.right_m += step.right_m;
    ticks.left_ticks = first.left_ticks + std::llround(all_m.left_m / drive.leftMetersPerTick());
    ticks.right_ticks =
        first.right_ticks + std::llround(all_m.right_m / drive.rightMetersPerTick());
  }
}

/// Each reading but the first, where time begins, arrives late by an exponential distribution, and
/// none before an earlier one.
void stampOnArrival(double mean_delay_s, std::uint64_t seed, SimulatedRecord* record) {
  constexpr Duration kApart = std::chrono::microseconds(1);
  Draws draws(seed, Draws::Purpose::kUnmodelled);
  for (std::size_t i = 1; i < record->ticks.size(); ++i) {
    Stamp& stamp = record->ticks[i].stamp;
    const double delay_s = -mean_delay_s * std::log(draws.between(1e-9, 1.0));
    stamp = std::max(record->ticks[i - 1].stamp + kApart, stamp + durationFromSeconds(delay_s));
  }
}

/// Student's t with 3 degrees of freedom, of the stated standard deviation.
void addHeavyTails(double stddev_rad, std::uint64_t seed, SimulatedRecord* record) {
  constexpr int kDegrees = 3;
  constexpr double kVariance = kDegrees / (kDegrees - 2.0);
  Draws draws(seed, Draws::Purpose::kUnmodelled);
  for (BearingSet& image : record->bearings) {
    for (Bearing& bearing : image.candidates) {
      double squares = 0.0;
      for (int i = 0; i < kDegrees; ++i) squares += std::pow(draws.gaussian(1.0), 2);
      const double t = draws.gaussian(1.0) / std::sqrt(squares / kDegrees);
      bearing.azimuth_rad = wrapAngle(bearing.azimuth_rad + stddev_rad / std::sqrt(kVariance) * t);
      bearing.azimuth_variance_rad2 = stddev_rad * stddev_rad;
    }
  }
}

}  // namespace

const std::vector<std::string>& unmodelledNames() {
  static const std::vector<std::string> kNames = {
      "none",        "swinging_separation", "sense_of_turn", "drifting_tyre", "lasting_noise",
      "heavy_tails", "coarse_ticks",        "two_grips",     "late_ticks",    "later_ticks"};
  return kNames;
}

Unmodelled unmodelledFrom(const std::string& name) {
  const std::vector<std::string>& names = unmodelledNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw std::invalid_argument("--unmodelled must be one of " + joined(names, ", ") + ", but is " +
                                name);
  }
  return static_cast<Unmodelled>(found - names.begin());
}

void makeUnmodelled(Unmodelled what, SimulatedCase& simulated) {
  RobotConfig& robot = simulated.robot;
  simulated.unmodelled = what;
  if (what == Unmodelled::kLastingNoise) {
    constexpr double kLasts_s = 3.0;
    const double interval_s = robot.steps_per_bearing * robot.step_s;
    robot.sensor.correlation = std::exp(-interval_s / kLasts_s);
  }
  if (what == Unmodelled::kCoarseTicks) {
    constexpr double kTick_m = 1e-3;
    DriveGeometry& drive = robot.encoders.drive;
    drive.ticks_per_revolution = 2.0 * kPi * drive.left_wheel_radius_m / kTick_m;
  }
}

void distort(const SimulatedCase& simulated, SimulatedRecord* record) {
  const RobotConfig& robot = simulated.robot;
  const DriveGeometry& drive = robot.encoders.drive;
  switch (simulated.unmodelled) {
    case Unmodelled::kSwingingSeparation:
      return distortTicks(drive, swingingSeparation(), record);
    case Unmodelled::kSenseOfTurn:
      return distortTicks(drive, senseOfTurn(), record);
    case Unmodelled::kDriftingTyre:
      return distortTicks(drive, driftingTyre(simulated.duration_s), record);
    case Unmodelled::kTwoGrips:
      return distortTicks(drive, twoGrips(robot.encoders.noise, robot.seed), record);
    case Unmodelled::kLateTicks:
      return stampOnArrival(0.01, robot.seed, record);
    case Unmodelled::kLaterTicks:
      return stampOnArrival(0.03, robot.seed, record);
    case Unmodelled::kHeavyTails:
      return addHeavyTails(robot.sensor.stddev_rad, robot.seed, record);
    case Unmodelled::kNone:
    case Unmodelled::kLastingNoise:
    case Unmodelled::kCoarseTicks:
      return;
  }
}

}  // namespace bearing_calibration::core
