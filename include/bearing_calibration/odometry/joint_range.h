#pragma once

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

/// The positions that a wheel's joint has had. While all of them, and zero, lie within one turn,
/// the joint may be one that wraps, at +-pi or from 2 pi to 0: it is taken the shorter way round. A
/// cumulative joint leaves one turn soon, and is taken as it says from then on.
class JointRange {
 public:
  void add(double position_rad) {
    least_rad_ = std::min(least_rad_, position_rad);
    most_rad_ = std::max(most_rad_, position_rad);
  }

  /// How far it has turned from one position to the next one.
  double turn(double from_rad, double to_rad) const {
    return mayWrapAt(to_rad) ? wrapAngle(to_rad - from_rad) : to_rad - from_rad;
  }

  /// Whether turn() rests on the guess that it has wrapped, and not turned by more than a half.
  bool seemsToWrap(double from_rad, double to_rad) const {
    return mayWrapAt(to_rad) && std::abs(to_rad - from_rad) > kPi;
  }

 private:
  bool mayWrapAt(double position_rad) const {
    constexpr double kRounding_rad = 1e-3;  // of drivers that count in floats
    return std::max(most_rad_, position_rad) - std::min(least_rad_, position_rad) <
           2.0 * kPi + kRounding_rad;
  }

  double least_rad_ = 0.0;
  double most_rad_ = 0.0;
};

}  // namespace bearing_calibration::core
