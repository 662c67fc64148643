#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/solve/batch_estimator.h"

namespace bearing_calibration::core {

/// How wrong what is stated of the noise may be: standard deviations of the natural logarithm of a
/// factor, 0.7 for a factor of two; 0: it is as stated.
struct NoisePriors {
  double bearing_stddev = 0.0;  ///< of the factor of all bearings' standard deviations
  double wheel_stddev = 0.0;    ///< of the factor of the wheels' variances

  bool any() const { return bearing_stddev > 0.0 || wheel_stddev > 0.0; }
  /// One sentence for each value that cannot be; empty when all is well.
  std::vector<std::string> validate() const;
};

/// A factor of what was stated, as the data have it.
struct NoiseFactor {
  double value = 1.0;
  double log_stddev = 0.0;  ///< of its natural logarithm; 0: not looked for
};

/// What a record says about its own noise.
struct NoiseLevels {
  NoiseFactor bearing;  ///< of the bearings' standard deviations
  NoiseFactor wheel;    ///< of the wheels' variances
};

/// Time in which a correlation of neighbouring bearings' noise falls to 1/e; 0 for none.
struct CorrelationTime {
  double value_s = 0.0;
  double stddev_s = 0.0;
};
CorrelationTime correlationTime(const std::vector<Observation>& observations, double correlation);

/// The factors that make the innovations of a settled fit most likely, priors and all
/// (doc/model.md, section "Noise levels"). What the fit left out stays out, motions that it gave up
/// stay given up.
/// @param observations  as stated, those of the fit
NoiseLevels findNoiseLevels(const std::vector<Observation>& observations, const BatchEstimate& fit,
                            const ErrorPriors& errors, const NoisePriors& priors);

/// The same with the noise that was found.
std::vector<Observation> withNoise(std::vector<Observation> observations, const NoiseLevels& noise);
std::vector<Bearing> withNoise(std::vector<Bearing> bearings, const NoiseLevels& noise);
OdometryIncrement withNoise(OdometryIncrement motion, const NoiseLevels& noise);

}  // namespace bearing_calibration::core
