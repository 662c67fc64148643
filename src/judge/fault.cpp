#include "bearing_calibration/judge/fault.h"

#include <array>
#include <cmath>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {

const char* nameOf(Fault fault) {
  static constexpr std::array<const char*, 14> kNames{
      "NONE",          "MIRRORED",    "LEFT_WHEEL_REVERSED", "RIGHT_WHEEL_REVERSED",
      "BEARINGS_LATE", "LEFT_RADIUS", "RIGHT_RADIUS",        "WHEEL_SEPARATION",
      "LIGHT_MOVED",   "MOUNT_MOVED", "LIGHTS_DISAGREE",     "PARTS_DISAGREE",
      "SCATTER",       "UNEXPLAINED",
  };
  static_assert(kNames.size() == static_cast<std::size_t>(Fault::kUnexplained) + 1);
  return kNames.at(static_cast<std::size_t>(fault));
}

std::string describe(const Diagnosis& diagnosis) {
  switch (diagnosis.fault) {
    case Fault::kMirrored:
      return "the bearings fit a mirrored motion: the left and right wheel are swapped, or both "
             "are reversed, or the azimuth grows clockwise (handedness)";
    case Fault::kLeftReversed:
      return "the bearings fit when the left wheel's counter is reversed";
    case Fault::kRightReversed:
      return "the bearings fit when the right wheel's counter is reversed";
    case Fault::kLate:
      return formatted(
          "the bearings fit when their stamps are taken as %.2f s %s: set bearings/latency",
          std::abs(diagnosis.size), diagnosis.size > 0.0 ? "late" : "early");
    case Fault::kLeftRadius:
    case Fault::kRightRadius:
      return formatted(
          "the bearings fit when %s is multiplied by about %.2f",
          diagnosis.fault == Fault::kLeftRadius ? "wheels/left_radius" : "wheels/right_radius",
          diagnosis.size);
    case Fault::kSeparation:
      return formatted(
          "the bearings fit when wheels/separation is multiplied by about %.2f, or both radii are "
          "divided by it",
          diagnosis.size);
    case Fault::kLightMoved:
      return "both halves of the drive give the same mount, but another place of the light: it has "
             "moved, or it is not always the same one";
    default:
      return "";
  }
}

}  // namespace bearing_calibration::core
