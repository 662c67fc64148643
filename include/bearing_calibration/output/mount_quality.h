#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

/// What would part two estimates that hang together, as far as the bound tells
/// (mount_quality_test).
enum class PartingMotion : std::uint8_t {
  kTurns,      ///< on the spot, a full turn to each side
  kNearer,     ///< to half the light's distance, then the same
  kDistances,  ///< turns on the spot at three distances from the light
  kNone,
};

/// How good a mount is for who uses it (doc/model.md, eqs. 26 and 27).
struct MountQuality {
  double light_ahead_stddev_m = 0.0;  ///< of where a light 3 m ahead is placed, its worst axis
  double worst_direction_rad = 0.0;   ///< of the position, in the base frame: (-pi/2, pi/2]
  double worst_stddev_m = 0.0;        ///< in that direction
  /// Two estimates, one of the mount at least; a high correlation alone is worth a word.
  struct Pair {
    int first = 0;  ///< places in (x, y, yaw, errors of the robot)
    int second = 0;
    double correlation = 0.0;  ///< with the wheel separation, all lengths' unit, as it is
  };
  std::optional<Pair> most_correlated;
};

MountQuality qualityOf(const StateEstimate& estimate);

PartingMotion motionThatParts(const MountQuality::Pair& pair);

/// The same as sentences, which every output says; none where the result may not be trusted.
std::vector<std::string> qualityInWords(const CalibrationResult& result);

}  // namespace bearing_calibration::core
