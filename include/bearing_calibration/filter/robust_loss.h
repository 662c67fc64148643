#pragma once

#include <cmath>

namespace bearing_calibration::core {

/// Huber's loss of a residual in standard deviations: squared up to a limit, linear beyond it.
struct Huber {
  double cost;
  double doubt;  ///< what a least-squares step multiplies the variance by, >= 1
};
inline Huber huber(double sigmas, double limit) {
  const double size = std::abs(sigmas);
  if (!(size > limit)) return {size * size, 1.0};
  return {limit * (2.0 * size - limit), size / limit};
}

/// An elevation beyond so many standard deviations counts linearly: it stands or falls with its
/// bearing, and has no other gate.
inline constexpr double kElevationHuberSigmas = 2.5;

}  // namespace bearing_calibration::core
