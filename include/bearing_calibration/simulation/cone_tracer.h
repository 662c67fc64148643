#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "bearing_calibration/simulation/camera_rig.h"

namespace bearing_calibration::core {

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
  SurfacePoint pathOver(double along_m, double azimuth_rad, const Eigen::Vector3d& light,
                        const Eigen::Vector3d& lens) const;
  std::optional<SurfacePoint> reflectionPoint(const Eigen::Vector3d& light,
                                              const Eigen::Vector3d& lens) const;
  double throughput(const SurfacePoint& point) const;
  Eigen::Vector3d inMirror(const Eigen::Vector3d& point) const;

  CameraRig rig_;
  double sin_tau_;
  double cos_tau_;
  Eigen::Matrix3d sensor_from_mirror_rotation_;
  Eigen::Vector3d apex_;  ///< in the sensor frame
};

}  // namespace bearing_calibration::core
