#pragma once

#include <Eigen/Core>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// A camera that looks straight up at a cone of which the apex points down, with a thin lens of
/// finite aperture. Frame of everything: the sensor frame (x forward, y left, z up), its origin at
/// the apex of an aligned mirror; the lens stands below it on the z axis.
struct CameraRig {
  int width_px = 640;
  int height_px = 480;
  Eigen::Vector2d centre_px = {319.5, 239.5};  ///< principal point; a pixel's centre is whole
  double pixel_m = 5.6e-6;
  double focal_length_m = 4e-3;
  double aperture_m = 1.7e-3;      ///< diameter
  double focus_distance_m = 0.06;  ///< of the plane that is sharp, from the lens
  /// +1: rows grow to the sensor's right (-y), as seen from above; -1: to its left, which is what
  /// a camera that looks up delivers when its driver does not flip the image.
  int handedness = -1;

  double lens_to_apex_m = 0.08;
  double cone_half_angle_rad = 0.9162978572970231;  ///< 52.5 degrees
  double mirror_radius_m = 0.035;                   ///< of the cone's base
  /// Lean of the mirror's axis: its direction is proportional to (x, y, 1).
  Eigen::Vector2d axis_lean = Eigen::Vector2d::Zero();
  Eigen::Vector2d apex_offset_m = Eigen::Vector2d::Zero();

  void declare(Parameters& params);

  /// From lens to image, by the thin lens equation.
  double imageDistance() const;
  /// Pixels per unit of a ray's slope against the optical axis.
  double pixelsPerSlope() const { return imageDistance() / pixel_m; }
};

}  // namespace bearing_calibration::core
