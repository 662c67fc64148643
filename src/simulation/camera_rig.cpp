#include "bearing_calibration/simulation/camera_rig.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

double CameraRig::imageDistance() const {
  return 1.0 / (1.0 / focal_length_m - 1.0 / focus_distance_m);
}

void CameraRig::declare(Parameters& params) {
  constexpr double kLargestLean = 0.2;  // of the mirror's axis; 11 degrees are no misalignment
  constexpr double kSmallestPixel_m = 1e-8;
  constexpr double kLargestPixel_m = 1e-2;
  constexpr double kLeast_m = 1e-6;  // of a lens or a mirror
  constexpr double kLargest_m = 10.0;
  constexpr double kPinhole_m = 1e-9;
  constexpr double kInfinity_m = 1e6;  // to focus on
  using plausible::kLargestSide_px;
  params.integer("camera/width", width_px, 1, kLargestSide_px);
  params.integer("camera/height", height_px, 1, kLargestSide_px);
  params.number("camera/centre_u", centre_px.x(), -kLargestSide_px, 2.0 * kLargestSide_px);
  params.number("camera/centre_v", centre_px.y(), -kLargestSide_px, 2.0 * kLargestSide_px);
  params.number("camera/pixel", pixel_m, kSmallestPixel_m, kLargestPixel_m);
  params.number("camera/focal_length", focal_length_m, kLeast_m, kLargest_m);
  params.number("camera/aperture", aperture_m, kPinhole_m, kLargest_m);
  params.read("camera/focus_distance", focus_distance_m);
  params.that(focus_distance_m > focal_length_m && focus_distance_m <= kInfinity_m,
              "camera/focus_distance must be greater than camera/focal_length and at most 1e6");
  params.read("camera/handedness", handedness);
  params.that(handedness == 1 || handedness == -1,
              "camera/handedness must be 1 or -1, but is " + std::to_string(handedness));
  params.number("mirror/lens_to_apex", lens_to_apex_m, kLeast_m, kLargest_m);
  params.read("mirror/cone_half_angle", cone_half_angle_rad);
  params.that(cone_half_angle_rad > 0.0 && cone_half_angle_rad < 0.5 * kPi,
              "mirror/cone_half_angle must lie between 0 and pi/2, but is " +
                  std::to_string(cone_half_angle_rad));
  params.number("mirror/radius", mirror_radius_m, kLeast_m, kLargest_m);
  params.read("mirror/lean_x", axis_lean.x());
  params.read("mirror/lean_y", axis_lean.y());
  params.that(axis_lean.norm() <= kLargestLean,
              "mirror/lean_x and mirror/lean_y together must not exceed 0.2");
  params.read("mirror/offset_x", apex_offset_m.x());
  params.read("mirror/offset_y", apex_offset_m.y());
  params.that(apex_offset_m.norm() < mirror_radius_m,
              "mirror/offset_x and mirror/offset_y must keep the apex inside mirror/radius");
}

}  // namespace bearing_calibration::core
