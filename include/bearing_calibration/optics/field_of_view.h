#pragma once

#include <cmath>
#include <initializer_list>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

/// The azimuths at which a sensor sees: a part of a turn about its z axis.
struct FieldOfView {
  double centre_rad = 0.0;
  double width_rad = 0.0;  ///< from border to border; 0: all around, or the sensor does not say

  bool isLimited() const { return width_rad > 0.0 && width_rad < 2.0 * kPi; }
  /// Whether a sensor can have it.
  bool isPossible() const {
    constexpr double kTurn_rad = 2.0 * kPi * (1.0 + 1e-6);  // 2 pi as a float is a little more
    return std::abs(centre_rad) <= kTurn_rad && width_rad >= 0.0 && width_rad <= kTurn_rad;
  }

  /// Probability that a light is in view whose azimuth is known so well.
  double chanceOf(double azimuth_rad, double stddev_rad) const {
    if (!isLimited()) return 1.0;
    const double off_rad = wrapAngle(azimuth_rad - centre_rad);
    const double half_rad = 0.5 * width_rad;
    if (!(stddev_rad > 0.0)) return std::abs(off_rad) <= half_rad ? 1.0 : 0.0;
    const auto below = [&](double border_rad) {
      return 0.5 * std::erfc((off_rad - border_rad) / (std::sqrt(2.0) * stddev_rad));
    };
    double chance = 0.0;
    for (const double turn_rad : {-2.0 * kPi, 0.0, 2.0 * kPi}) {
      chance += below(turn_rad + half_rad) - below(turn_rad - half_rad);
    }
    return chance;
  }
};

}  // namespace bearing_calibration::core
