#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/initializer.h"

namespace bearing_calibration {

/// What may be wrong with a robot whose bearings do not fit its motion. Faults that give the same
/// data, up to another mount, are one entry: they cannot be told apart (doc/faults.md).
enum class Fault : std::uint8_t {
  kNone,
  kMirrored,       ///< left and right wheel swapped, or both reversed, or the bearing's sense
  kLeftReversed,   ///< the left counter counts backwards
  kRightReversed,  ///< the right counter counts backwards
  kLate,           ///< the bearings' stamps are late against the wheels', or early
  kLeftRadius,     ///< of the left wheel
  kRightRadius,    ///< of the right wheel
  kSeparation,     ///< the wheel separation, against the radii
  kLightMoved,     ///< one mount, but another place of the light in the second half
};

/// A fault and its size.
struct Diagnosis {
  Fault fault = Fault::kNone;
  /// kLate: seconds by which the stamps are late. Radii and separation: by what the believed value
  /// must be multiplied.
  double size = 0.0;
};

/// "the left and right wheel seem to be swapped, or ..." and what to do about it.
std::string describe(const Diagnosis& diagnosis);

/// Looks for the one fault that makes a record fit: undoes each in turn and starts from nothing on
/// what is left. kNone when no single fault does, or when the record fits as it is.
/// @param wheel_separation_m  as believed
Diagnosis findFault(const std::vector<Sight>& sights, double wheel_separation_m,
                    const InitializerConfig& config);

}  // namespace bearing_calibration
