#pragma once

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/optics/conic_mirror.h"

namespace bearing_calibration::core {
namespace test {

inline constexpr double kDefaultLightHeight_m = -0.03;

/// The rig that the shipped configuration describes.
inline ConicMirror defaultMirror() {
  ConicMirror mirror;
  mirror.focal_length_m = 4e-3;
  mirror.aperture_m = 1.7e-3;
  mirror.focus_distance_m = 0.06;
  mirror.pixel_pitch_m = 5.6e-6;
  mirror.lens_to_apex_m = 0.08;
  mirror.half_angle_rad = radiansFromDegrees(52.5);
  mirror.base_radius_m = 0.035;
  return mirror;
}

}  // namespace test
}  // namespace bearing_calibration::core
