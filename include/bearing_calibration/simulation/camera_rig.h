#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

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

/// Exact rays between the world and the image by way of the conic mirror. It shares nothing with
/// the optics that the light detector uses, so that the one can be tested against the other.
class ConeTracer {
 public:
  /// Where one ray of a light ends.
  struct SensorHit {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< (column, row), fractions included
    double throughput = 0.0;  ///< solid angle at the light per area of the aperture [sr/m^2]
  };

  /// @throws std::invalid_argument with what errorsOf() says.
  explicit ConeTracer(const CameraRig& rig);

  /// The ray from `light_m` over the mirror to the point `aperture_m` of the lens; none when the
  /// mirror does not reflect it there. By Fermat's principle: Newton's method on the gradient of
  /// the path's length over the two coordinates of the mirror's surface.
  std::optional<SensorHit> rayFrom(const Eigen::Vector3d& light_m,
                                   const Eigen::Vector2d& aperture_m) const;

  /// Unit vector from the mirror to what `pixel` sees through the middle of the lens; none when
  /// it looks past the mirror.
  std::optional<Eigen::Vector3d> directionSeenBy(const Eigen::Vector2d& pixel) const;

  const CameraRig& rig() const { return rig_; }

 private:
  struct SurfacePoint;  // on the cone, with the path over it
  std::optional<SurfacePoint> reflectionPoint(const Eigen::Vector3d& light,
                                              const Eigen::Vector3d& lens) const;
  double throughput(const SurfacePoint& point) const;
  /// Unit vector along the surface, away from the apex.
  Eigen::Vector3d along(const Eigen::Vector3d& outward) const;
  Eigen::Vector3d inMirror(const Eigen::Vector3d& point) const;

  CameraRig rig_;
  double sin_tau_;
  double cos_tau_;
  Eigen::Matrix3d sensor_from_mirror_rotation_;
  Eigen::Vector3d apex_;  ///< in the sensor frame
};

}  // namespace bearing_calibration::core
