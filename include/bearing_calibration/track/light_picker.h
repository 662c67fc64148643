#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {

/// Chooses the light among an image's candidates while neither mount nor light is known: follows
/// its azimuth, and how that changes with the way, by a Kalman filter.
class LightPicker {
 public:
  /// The base has moved since the last look.
  void move(const OdometryIncrement& motion);
  /// @param may_be_others  candidates may be other lights; where none is, what is seen far from the
  ///   expected place is the light all the same, the nearest or else the likeliest
  Association pick(const std::vector<Bearing>& candidates, bool may_be_others);
  /// The light was hidden, or near another, for so long that among others nobody knows which one it
  /// is.
  bool isLost() const;

 private:
  Association nearestOrLikeliest(Association nearest, const std::vector<Bearing>& candidates,
                                 bool may_be_others) const;
  void take(const Bearing& light, const Innovation& innovation);

  /// Azimuth [rad], and its change as the base drives ahead [rad/m].
  struct Direction {
    Eigen::Vector2d mean;
    Eigen::Matrix2d covariance;
  };

  std::optional<Direction> direction_;
  bool has_light_ = false;  ///< in the last image
};

}  // namespace bearing_calibration::core
