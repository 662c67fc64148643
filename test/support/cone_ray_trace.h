#pragma once

#include <Eigen/Core>

#include "bearing_calibration/optics/conic_mirror.h"

namespace bearing_calibration::core {
namespace test {

/// How a real rig departs from ConicMirror's drawing.
struct ConeMisalignment {
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();      ///< the axis is (tilt_x, tilt_y, 1)
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();  ///< of the apex
};

/// Where the ray that runs from `light_m` over the cone to `aperture_m` (on the lens' plane) meets
/// the image, in pixels about the principal point, in sensor axes. It is found by Newton's method
/// on the law of reflection in space: nothing of optics/conic_mirror.cpp is used. Origin: the apex
/// of the aligned rig.
Eigen::Vector2d traceToImage(const ConicMirror& mirror, const ConeMisalignment& misalignment,
                             const Eigen::Vector3d& light_m, const Eigen::Vector2d& aperture_m);

}  // namespace test
}  // namespace bearing_calibration::core
