#include "bearing_calibration/simulation/camera_rig.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration::core {

double CameraRig::imageDistance() const {
  return 1.0 / (1.0 / focal_length_m - 1.0 / focus_distance_m);
}

std::vector<std::string> CameraRig::validate() const {
  constexpr double kLargestLean = 0.2;  // of the mirror's axis; 11 degrees are no misalignment
  Requirements require;
  constexpr double kSmallestPixel_m = 1e-8;
  constexpr double kLargestPixel_m = 1e-2;
  constexpr double kLeast_m = 1e-6;  // of a lens or a mirror
  constexpr double kLargest_m = 10.0;
  constexpr double kInfinity_m = 1e6;  // to focus on
  using plausible::kLargestSide_px;
  require.between("camera/width", width_px, 1, kLargestSide_px);
  require.between("camera/height", height_px, 1, kLargestSide_px);
  require.between("camera/centre_u", centre_px.x(), -kLargestSide_px, 2.0 * kLargestSide_px);
  require.between("camera/centre_v", centre_px.y(), -kLargestSide_px, 2.0 * kLargestSide_px);
  require.between("camera/pixel", pixel_m, kSmallestPixel_m, kLargestPixel_m);
  require.between("camera/focal_length", focal_length_m, kLeast_m, kLargest_m);
  constexpr double kPinhole_m = 1e-9;
  require.between("camera/aperture", aperture_m, kPinhole_m, kLargest_m);
  require.that(focus_distance_m > focal_length_m && focus_distance_m <= kInfinity_m,
               "camera/focus_distance must be greater than camera/focal_length and at most 1e6");
  require.that(handedness == 1 || handedness == -1,
               "camera/handedness must be 1 or -1, but is " + std::to_string(handedness));
  require.between("mirror/lens_to_apex", lens_to_apex_m, kLeast_m, kLargest_m);
  require.that(cone_half_angle_rad > 0.0 && cone_half_angle_rad < 0.5 * kPi,
               "mirror/cone_half_angle must lie between 0 and pi/2, but is " +
                   std::to_string(cone_half_angle_rad));
  require.between("mirror/radius", mirror_radius_m, kLeast_m, kLargest_m);
  require.that(axis_lean.norm() <= kLargestLean,
               "mirror/lean_x and mirror/lean_y together must not exceed 0.2");
  require.that(apex_offset_m.norm() < mirror_radius_m,
               "mirror/offset_x and mirror/offset_y must keep the apex inside mirror/radius");
  return require.errors();
}

}  // namespace bearing_calibration::core
