#include "bearing_calibration/simulation/camera_rig.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration {

double CameraRig::imageDistance() const {
  return 1.0 / (1.0 / focal_length_m - 1.0 / focus_distance_m);
}

std::vector<std::string> CameraRig::validate() const {
  constexpr int kLargestSize = 16384;   // pixels; beyond, a wrong unit is likelier than a camera
  constexpr double kLargestLean = 0.2;  // of the mirror's axis; 11 degrees are no misalignment
  Requirements require;
  require.between("camera/width", width_px, 1, kLargestSize);
  require.between("camera/height", height_px, 1, kLargestSize);
  require.that(centre_px.allFinite(), "camera/centre_u and camera/centre_v must be finite");
  require.positive("camera/pixel", pixel_m);
  require.positive("camera/focal_length", focal_length_m);
  require.positive("camera/aperture", aperture_m);
  require.that(std::isfinite(focus_distance_m) && focus_distance_m > focal_length_m,
               "camera/focus_distance must be larger than camera/focal_length, but is " +
                   std::to_string(focus_distance_m));
  require.that(handedness == 1 || handedness == -1,
               "camera/handedness must be 1 or -1, but is " + std::to_string(handedness));
  require.positive("mirror/lens_to_apex", lens_to_apex_m);
  require.that(cone_half_angle_rad > 0.0 && cone_half_angle_rad < 0.5 * kPi,
               "mirror/cone_half_angle must lie between 0 and pi/2, but is " +
                   std::to_string(cone_half_angle_rad));
  require.positive("mirror/radius", mirror_radius_m);
  require.that(axis_lean.norm() <= kLargestLean,
               "mirror/lean_x and mirror/lean_y together must not exceed 0.2");
  require.that(apex_offset_m.norm() < mirror_radius_m,
               "mirror/offset_x and mirror/offset_y must keep the apex inside mirror/radius");
  return require.errors();
}

}  // namespace bearing_calibration
