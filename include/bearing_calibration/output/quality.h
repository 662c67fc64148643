#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/output/result.h"

// How good a result is: what the data said of each error of the robot, and what the mount is good
// for.

namespace bearing_calibration::core {

/// How a block of the robot's errors stands; the values are those of CalibrationEstimate.msg.
enum class BlockStatus : std::uint8_t {
  kOff,          ///< not looked for
  kHeldAtPrior,  ///< looked for, but the data hardly say more than was known before
  kEstimated,
};

/// "off", "held at its prior" or "estimated".
const char* nameOf(BlockStatus status);

/// One number of a block; zero where it is off.
struct ReportedNumber {
  Quantity quantity;
  double value = 0.0;
  double stddev = 0.0;
};

/// What is known of one block of the robot's errors.
struct BlockReport {
  std::string name;
  BlockStatus status = BlockStatus::kOff;
  std::vector<ReportedNumber> numbers;
  std::string note;  ///< what it means for the result that it is held; empty otherwise
};

/// Every block, judged by the information that the data added to its prior: it is estimated when in
/// every direction of the block they added at least as much as was there before.
/// @param tilt_stddev_rad  of a tilt of the sensor that is not looked for: where the light's height
///   is stated, a note says what it leaves open
std::vector<BlockReport> reportBlocks(const ErrorPriors& priors, const ErrorEstimate& estimate,
                                      double tilt_stddev_rad = 0.0);

/// The levels of the noise, judged alike: factors of the bearings' stated standard deviation and of
/// the wheels' stated variance, the light's size, and the correlation time of the bearings' noise.
std::vector<BlockReport> reportNoise(const NoisePriors& priors, const NoiseLevels& noise,
                                     const CorrelationTime& correlation);

/// Both of a result, the errors first.
std::vector<BlockReport> reportErrors(const CalibrationResult& result,
                                      double tilt_stddev_rad = 0.0);

/// How good a mount is for who uses it (model.md, eqs. 26 and 27).
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

/// What would part two estimates that hang together, as far as the bound tells
/// (mount_quality_test).
enum class PartingMotion : std::uint8_t {
  kTurns,      ///< on the spot, a full turn to each side
  kNearer,     ///< to half the light's distance, then the same
  kDistances,  ///< turns on the spot at three distances from the light
  kNone,
};
PartingMotion motionThatParts(const MountQuality::Pair& pair);

/// The same as sentences, which every output says; none where the result may not be trusted.
std::vector<std::string> qualityInWords(const CalibrationResult& result);

}  // namespace bearing_calibration::core
