#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/state.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// What is known of the robot's errors beforehand.
struct ErrorPriors {
  ErrorVector stddev = ErrorVector::Zero();  ///< zero: that error is known to be the mean
  ErrorVector mean = ErrorVector::Zero();    ///< zero but for what is looked for about it
  double light_height_m = 0.0;               ///< as stated, looked for or not
  double light_height_stddev_m = 0.0;        ///< the same
  /// How far a misaligned mirror may shift the sensor, to every side: no bearing tells it, so that
  /// it is no error in the state, but a part of what is said of the mount (withNearness()).
  double nearness_stddev_m = 0.0;

  /// Sets the standard deviation of a whole block, times its weights for each of its numbers.
  /// @throws std::invalid_argument when no block is called so
  void setBlock(const std::string& name, double stddev);

  /// What is known of the light's height over the sensor [m]: without effect where no tilt of the
  /// sensor is looked for.
  void setLightHeight(double mean_m, double stddev_m);

  /// Looks for the misaligned mirror that a sensor's geometry leaves room for.
  void setGeometry(const SensorGeometry& geometry);
  /// What of it is looked for.
  SensorGeometry geometry() const;

  template <typename Block>
  bool areEstimated() const {
    return (stddev.segment<Block::kSize>(placeOf<Block>()).array() > 0.0).any();
  }
  /// Whether elevations of the light tell anything that is looked for.
  bool usesElevations() const { return areEstimated<SensorTilt>(); }

  void declare(Parameters& params);
};

/// The mount with what the sensor's nearness leaves open of it.
StateEstimate withNearness(StateEstimate estimate, double nearness_stddev_m);
/// What bearings determine of it: the opposite.
StateEstimate withoutNearness(StateEstimate estimate, double nearness_stddev_m);

/// Before anything is measured, of one light.
ErrorEstimate priorEstimate(const ErrorPriors& priors);

/// How many of the errors, from the first on, an estimate of so many lights must have so that all
/// blocks with a prior are among them.
int errorsInUse(const ErrorPriors& priors, int lights = 1);
/// The height of a light, among the errors.
inline constexpr int heightAt(int light) {
  return placeOf<SensorTilt>() + SensorTilt::kHeights + light;
}

/// Those of clock and wheels come first.
inline constexpr int kWheelErrors = placeOf<MirrorHarmonic>();

/// Whether an error is the same when the robot starts anew.
bool lasts(int error);

/// Each of the errors.
const std::vector<Quantity>& errorQuantities();
/// "time_offset [s]"; a ratio has no unit.
std::string labelOf(const Quantity& quantity);

/// A block by its name and its place among the errors.
struct ErrorBlockInfo {
  std::string name;
  int begin = 0;
  int size = 0;
  std::string when_held;  ///< what it means for the result when the data do not tell it
};
const std::vector<ErrorBlockInfo>& errorBlocks();

}  // namespace bearing_calibration::core
