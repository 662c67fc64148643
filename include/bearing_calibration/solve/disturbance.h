#pragma once

#include "bearing_calibration/filter/lights_state.h"

namespace bearing_calibration::core {

/// One measured number, linearised about the path.
struct LinearNumber {
  LightsVector H;  ///< as a column
  LightsVector gain;
  double innovation;  ///< against the state before it, through the linearisation at the path
  double innovation_variance;
  double pull_variance;  ///< of innovation / innovation_variance
};

/// What everything after a moment says of the state at that moment, on the way back through a
/// record: disturbance r and its information N (de Jong and Penzer 1998).
class Disturbance {
 public:
  explicit Disturbance(const LightsLayout& layout);

  const LightsVector& r() const { return r_; }
  const LightsMatrix& N() const { return N_; }

  /// Goes back over a number that was taken in.
  /// @param future  N times the number's gain
  void add(const LinearNumber& number, const LightsVector& future);
  /// Goes back over a motion.
  void passMotion(const LightsMotion& motion);

  /// What an unknown jump of the base at this moment would take off the cost. Only those of its
  /// directions count in which the other observations tell a jump that is small against the lights'
  /// range: in the others a gain is an accident of the linearisation.
  /// @param range_m2  squared, the sum over all lights
  double slipGain(const LightsMotion& motion, double range_m2) const;

 private:
  LightsLayout layout_;
  LightsVector r_;
  LightsMatrix N_;
};

}  // namespace bearing_calibration::core
