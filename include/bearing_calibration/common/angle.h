#pragma once

#include <cmath>

namespace bearing_calibration::core {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegreesPerRadian = 180.0 / kPi;

/// Angle [rad] of any size -> the same direction in [-pi, pi]. NaN and infinity give NaN.
/// The only wrapping in the package.
inline double wrapAngle(double angle_rad) {
  // Most angles are there already, and the remainder is slow.
  return std::abs(angle_rad) <= kPi ? angle_rad : std::remainder(angle_rad, 2.0 * kPi);
}

constexpr double radiansFromDegrees(double angle_deg) { return angle_deg / kDegreesPerRadian; }
constexpr double degreesFromRadians(double angle_rad) { return angle_rad * kDegreesPerRadian; }

}  // namespace bearing_calibration::core
