#pragma once

#include <Eigen/Core>

namespace bearing_calibration::core {

/// A light as a level sensor would see it, and how the real one is tilted: Ry(pitch) Rx(roll) is
/// its orientation in the level one (REP 103: roll about x, then pitch about y).
struct LevelObservation {
  double azimuth_rad = 0.0;
  double range_m = 0.0;   ///< in the plane, > 0
  double height_m = 0.0;  ///< of the light over the sensor
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
};

/// An angle of the tilted sensor and its Jacobian by azimuth, range, roll, pitch and height.
struct TiltedAngle {
  double angle_rad;
  Eigen::Matrix<double, 1, 5> J_angle_level;
};

/// model.md, eqs. 20 and 21. The azimuth is not defined along the tilted sensor's z axis.
TiltedAngle tiltedAzimuth(const LevelObservation& level);
TiltedAngle tiltedElevation(const LevelObservation& level);

}  // namespace bearing_calibration::core
