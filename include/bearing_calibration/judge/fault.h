#pragma once

#include <cstdint>
#include <string>

namespace bearing_calibration::core {

/// What is wrong where bearings and motion do not fit; the values are those of
/// CalibrationEstimate.msg. Faults that give the same data, up to another mount, are one entry:
/// they cannot be told apart (faults.md).
enum class Fault : std::uint8_t {
  kNone,
  kMirrored,        ///< left and right wheel swapped, or both reversed, or the bearing's sense
  kLeftReversed,    ///< the left counter counts backwards
  kRightReversed,   ///< the right counter counts backwards
  kLate,            ///< the bearings' stamps are late against the wheels', or early
  kLeftRadius,      ///< of the left wheel
  kRightRadius,     ///< of the right wheel
  kSeparation,      ///< the wheel separation, against the radii
  kLightMoved,      ///< one mount, but another place of the light in the second half
  kMountMoved,      ///< since the calibration converged
  kLightsDisagree,  ///< one light gives another mount than the others
  kPartsDisagree,   ///< two parts of the drive give different mounts
  kScatter,         ///< the bearings scatter more than they should, or do not fit at all
  kUnexplained,     ///< no mount fits, and no single fault explains it
};

/// "MIRRORED" and so on.
const char* nameOf(Fault fault);

/// A fault and its size.
struct Diagnosis {
  Fault fault = Fault::kNone;
  /// kLate: seconds by which the stamps are late. Radii and separation: by what the nominal value
  /// must be multiplied.
  double size = 0.0;
};

/// What speaks for one of the faults up to kLightMoved, and what to do about it; empty for others.
std::string describe(const Diagnosis& diagnosis);

}  // namespace bearing_calibration::core
