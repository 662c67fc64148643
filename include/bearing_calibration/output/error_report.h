#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/solve/noise_levels.h"

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
/// the wheels' stated variance, and the time in which the bearings' noise forgets itself.
std::vector<BlockReport> reportNoise(const NoisePriors& priors, const NoiseLevels& noise,
                                     const CorrelationTime& correlation);

}  // namespace bearing_calibration::core
