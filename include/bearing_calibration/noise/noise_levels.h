#pragma once

#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// A factor of what was stated, as the data have it.
struct NoiseFactor {
  double value = 1.0;
  double log_stddev = 0.0;  ///< of its natural logarithm; 0: not looked for
};

/// How far the point that is seen lies beside the light's place, across the line of sight.
struct LightSize {
  double stddev_m = 0.0;
  double log_stddev = 0.0;  ///< of its natural logarithm; 0: not estimated
};

/// What a record says about its own noise.
struct NoiseLevels {
  NoiseFactor bearing;     ///< of the bearings' standard deviations
  NoiseFactor wheel;       ///< of the wheels' variances
  LightSize light_size{};  ///< beside the bearings' own noise

  /// What they are hardly above.
  NoiseLevels atMost() const;
  /// With the weight that bearings have whose neighbours' noise is so correlated.
  NoiseLevels widenedFor(double bearing_correlation) const;
  /// The variance of bearings or wheels over that of others, the larger factor of both.
  double varianceOver(const NoiseLevels& others) const;
};
/// The lower ones of each.
NoiseLevels atMost(NoiseLevels levels, const NoiseLevels& limit);

/// How wrong what is stated of the noise may be: standard deviations of the natural logarithm of a
/// factor, 0.7 for a factor of two; 0: it is as stated.
struct NoisePriors {
  double bearing_stddev = 0.0;  ///< of the factor of all bearings' standard deviations
  double wheel_stddev = 0.0;    ///< of the factor of the wheels' variances

  bool any() const { return bearing_stddev > 0.0 || wheel_stddev > 0.0; }
  /// Of the logarithm of the light's size, which is not known where the bearings' noise is not. It
  /// is usually a millimetre.
  double lightSizeStddev() const { return bearing_stddev; }
  static constexpr double kUsualLightSize_m = 1e-3;
  /// Whether levels are so far from what was stated that a fault of the robot is as likely.
  bool isSurprisedBy(const NoiseLevels& levels) const;
  void declare(Parameters& params);
};

/// Time in which a correlation of neighbouring bearings' noise falls to 1/e; 0 for none.
struct CorrelationTime {
  double value_s = 0.0;
  double stddev_s = 0.0;
};
CorrelationTime correlationTime(const std::vector<Observation>& observations, double correlation);

/// The bearings' standard deviation over the stated one, from how neighbouring bearings differ that
/// follow each other as they mostly do, the base's turn taken off: no mount is needed. A light that
/// is passed quickly makes it larger. 1 where there are too few.
double bearingLevelFromDifferences(const std::vector<Observation>& observations);

/// By so much the covariance of a motion is larger than stated: what nobody has seen of it is not
/// known any better because the wheels are.
inline double wheelFactor(double found, bool has_unseen) {
  return has_unseen && found < 1.0 ? 1.0 : found;
}

/// The same with the noise that was found.
Observation withNoise(Observation observation, const NoiseLevels& noise);
std::vector<Observation> withNoise(std::vector<Observation> observations, const NoiseLevels& noise);
/// @param range_m  to the light
Bearing withNoise(Bearing bearing, const NoiseLevels& noise, double range_m);
std::vector<Bearing> withNoise(std::vector<Bearing> bearings, const NoiseLevels& noise,
                               double range_m);
OdometryIncrement withNoise(OdometryIncrement motion, const NoiseLevels& noise);

}  // namespace bearing_calibration::core
