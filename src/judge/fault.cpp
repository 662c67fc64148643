#include "bearing_calibration/judge/fault.h"

#include <cmath>
#include <cstdio>

namespace bearing_calibration::core {

const char* nameOf(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return "NONE";
    case Fault::kMirrored:
      return "MIRRORED";
    case Fault::kLeftReversed:
      return "LEFT_WHEEL_REVERSED";
    case Fault::kRightReversed:
      return "RIGHT_WHEEL_REVERSED";
    case Fault::kLate:
      return "BEARINGS_LATE";
    case Fault::kLeftRadius:
      return "LEFT_RADIUS";
    case Fault::kRightRadius:
      return "RIGHT_RADIUS";
    case Fault::kSeparation:
      return "WHEEL_SEPARATION";
    case Fault::kLightMoved:
      return "LIGHT_MOVED";
    case Fault::kMountMoved:
      return "MOUNT_MOVED";
    case Fault::kLightsDisagree:
      return "LIGHTS_DISAGREE";
    case Fault::kPartsDisagree:
      return "PARTS_DISAGREE";
    case Fault::kScatter:
      return "SCATTER";
    case Fault::kUnexplained:
      return "UNEXPLAINED";
  }
  return "UNKNOWN";
}

std::string describe(const Diagnosis& diagnosis) {
  char text[256];
  switch (diagnosis.fault) {
    case Fault::kMirrored:
      return "the bearings fit a mirrored motion: the left and right wheel are swapped, or both "
             "are reversed, or the azimuth grows clockwise (handedness)";
    case Fault::kLeftReversed:
      return "the bearings fit when the left wheel's counter is reversed";
    case Fault::kRightReversed:
      return "the bearings fit when the right wheel's counter is reversed";
    case Fault::kLate:
      std::snprintf(
          text, sizeof(text),
          "the bearings fit when their stamps are taken as %.2f s %s: set bearings/latency",
          std::abs(diagnosis.size), diagnosis.size > 0.0 ? "late" : "early");
      return text;
    case Fault::kLeftRadius:
    case Fault::kRightRadius:
      std::snprintf(
          text, sizeof(text), "the bearings fit when %s is multiplied by about %.2f",
          diagnosis.fault == Fault::kLeftRadius ? "wheels/left_radius" : "wheels/right_radius",
          diagnosis.size);
      return text;
    case Fault::kSeparation:
      std::snprintf(text, sizeof(text),
                    "the bearings fit when wheels/separation is multiplied by about %.2f, or both "
                    "radii are divided by it",
                    diagnosis.size);
      return text;
    case Fault::kLightMoved:
      return "both halves of the drive give the same mount, but another place of the light: it has "
             "moved, or it is not always the same one";
    default:
      return "";
  }
}

}  // namespace bearing_calibration::core
