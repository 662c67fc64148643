#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// Chooses the light among an image's candidates while nothing is known yet: the one nearest to
/// where the last choice has turned to with the base, or else the one of the highest probability.
class LightPicker {
 public:
  /// The base has moved since the last look.
  void move(const OdometryIncrement& motion);
  /// None when there is no candidate.
  std::optional<Bearing> pick(const std::vector<Bearing>& candidates);

 private:
  std::optional<double> expected_azimuth_rad_;
};

}  // namespace bearing_calibration::core
