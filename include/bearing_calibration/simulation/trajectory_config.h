#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/trajectory.h"

namespace bearing_calibration::core {

/// A trajectory by its name and measures. The defaults are the paper's (section V-A).
struct TrajectoryConfig {
  enum class Kind : std::uint8_t {
    kDance,         ///< straight, then a long spin to the left: the paper's second trajectory
    kTurns,         ///< straight, then 90 degrees to the left
    kSinusoid,      ///< meandering
    kRandom,        ///< the paper's first trajectory
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
  double random_variance_m = 0.01;  ///< variance of a wheel's step over its mean [m^2/m]
  std::uint64_t seed = 1;           ///< of the random trajectory

  void declare(Parameters& params);
};

/// Names of the kinds in their order, as used in configuration files.
const std::vector<std::string>& trajectoryNames();

/// @throws std::invalid_argument with what errorsOf() says, or for a separation that is not > 0.
std::unique_ptr<Trajectory> makeTrajectory(const TrajectoryConfig& config,
                                           double wheel_separation_m);

}  // namespace bearing_calibration::core
