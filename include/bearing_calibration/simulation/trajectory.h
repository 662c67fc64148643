#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/odometry/odometry_increment.h"

namespace bearing_calibration::core {

/// How the wheels of a robot roll over the ground, one step after the other: what each of them
/// rolls during the next `step_s` > 0 seconds.
using Trajectory = std::function<WheelDisplacement(double step_s)>;

/// A piece of constant wheel speeds.
struct DriveSegment {
  double left_mps = 0.0;
  double right_mps = 0.0;
  double duration_s = 0.0;
};

/// Segments driven one after the other, over and over.
/// @throws std::invalid_argument without a segment, or when one does not last.
Trajectory segmentTrajectory(std::vector<DriveSegment> segments);

/// Another trajectory for a while, standing still for ever after.
Trajectory limitedTrajectory(Trajectory trajectory, double duration_s);

/// Follows velocity commands; stands still when none came for `timeout_s`.
class CommandedTrajectory {
 public:
  CommandedTrajectory(double wheel_separation_m, double max_wheel_speed_mps, double timeout_s);

  /// The velocity of the base from now on; slowed down, with its curvature kept, when a wheel would
  /// be faster than it can.
  void command(double forward_mps, double turn_radps);
  WheelDisplacement advance(double step_s);

 private:
  double wheel_separation_m_;
  double max_wheel_speed_mps_;
  double timeout_s_;
  DriveSegment command_;  ///< its duration is what remains before the time-out
};

/// A trajectory by its name and measures. The defaults are the paper's (section V-A).
struct TrajectoryConfig {
  enum class Kind : std::uint8_t {
    kDance,         ///< straight, then a long spin to the left: the paper's second trajectory
    kTurns,         ///< straight, then 90 degrees to the left
    kSinusoid,      ///< meandering: constant speed, the heading swings like a sine
    kRandom,        ///< the paper's first: each wheel's step is Gaussian, its variance k v dt
    kStanding,      ///< not at all
    kLine,          ///< straight on
    kBackAndForth,  ///< straight on and straight back
    kCircle,        ///< to the left
    kSpin,          ///< on the spot, to the left
  };
  Kind kind = Kind::kDance;
  double wheel_speed_mps = 0.2;   ///< of the faster wheel (of the centre: sinusoid; mean: random)
  double segment_length_m = 1.0;  ///< straight pieces of dance, turns, back and forth
  double dance_turn_rad = 2.5 * kPi;
  double circle_radius_m = 0.5;
  double sinusoid_amplitude_rad = kPi / 3.0;
  double sinusoid_period_s = 15.0;
  double random_variance_m = 0.01;  ///< k: variance of a wheel's step over its mean [m^2/m]
  std::uint64_t seed = 1;           ///< of the random trajectory

  void declare(Parameters& params);
};

/// Names of the kinds in their order, as used in configuration files.
const std::vector<std::string>& trajectoryNames();

/// @throws std::invalid_argument with what errorsOf() says, or for a separation that is not > 0.
Trajectory makeTrajectory(const TrajectoryConfig& config, double wheel_separation_m);

}  // namespace bearing_calibration::core
