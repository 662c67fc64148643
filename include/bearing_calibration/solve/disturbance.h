#pragma once

#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/motion_model.h"

namespace bearing_calibration::core {

/// What everything after a moment says of the state at that moment, on the way back through a
/// record: disturbance r and its information N (de Jong and Penzer 1998).
class Disturbance {
 public:
  explicit Disturbance(const StateLayout& layout);

  const StateVector& r() const { return r_; }
  const StateMatrix& N() const { return N_; }

  /// Goes back over a number that was taken in.
  /// @param pull_variance  of its innovation over the innovation's variance
  /// @param future  N times its gain
  void add(const ScalarUpdate& number, double pull_variance, const StateVector& future);
  /// Goes back over a motion.
  void passMotion(const LinearMotion& motion);

  /// What an unknown jump of the base at this moment would take off the cost. Only those of its
  /// directions count in which the other observations tell a jump that is small against the lights'
  /// range: in the others a gain is an accident of the linearisation.
  /// @param range_m2  squared, the sum over all lights
  double slipGain(const LinearMotion& motion, double range_m2) const;

 private:
  StateLayout layout_;
  StateVector r_;
  StateMatrix N_;
};

}  // namespace bearing_calibration::core
