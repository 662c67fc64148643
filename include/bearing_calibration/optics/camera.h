#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "bearing_calibration/optics/field_of_view.h"

namespace bearing_calibration::core {

/// How a lens maps directions, with its coefficients in the order of sensor_msgs/CameraInfo.
enum class Lens : std::uint8_t {
  kPerspective,  ///< k1 k2 p1 p2 k3 k4 k5 k6: plumb_bob (0 from the sixth on), rational_polynomial
  kFisheye,      ///< k1 k2 k3 k4: equidistant
};

/// A camera without a mirror, by the numbers of its calibration. Its optical frame has its origin
/// in the lens, z ahead, x to the right and y down in the image; the sensor frame has the same
/// origin.
///
/// A ray (x, y, z) has the image (focal_u a + centre_u, focal_v b + centre_v). Perspective: with
/// (x, y) over z and r their norm, s = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6
/// r^6), a = s x + 2 p1 x y + p2 (r^2 + 2 x^2), b = s y + p1 (r^2 + 2 y^2) + 2 p2 x y. Fisheye:
/// with t the angle between ray and axis, (a, b) has the ray's direction in the image and the
/// length t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8). Either holds up to the first r or t, beyond
/// which it would grow no more.
struct Camera {
  double focal_u_px = 0.0;
  double focal_v_px = 0.0;
  double centre_u_px = 0.0;  ///< column; integer values are pixel centres
  double centre_v_px = 0.0;  ///< row, growing downwards
  Lens lens = Lens::kPerspective;
  std::array<double, 8> distortion{};
  /// A level camera that looks along the sensor frame's x axis.
  Eigen::Matrix3d sensor_from_optical =
      (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();

  bool operator==(const Camera& other) const;
};

/// Why these are no numbers of a camera, in a sentence; empty for those that are.
std::string whyNoCamera(const Camera& camera);

/// The image [px] of a ray in the optical frame, of any length; none where the lens shows none.
std::optional<Eigen::Vector2d> pixelFromRay(const Camera& camera, const Eigen::Vector3d& ray);

/// The unit ray in the optical frame that a place in the image shows, to 1e-9 rad; none beyond what
/// the lens shows.
std::optional<Eigen::Vector3d> rayFromPixel(const Camera& camera, const Eigen::Vector2d& pixel);

/// Of a ray in the sensor frame.
struct Direction {
  double azimuth_rad = 0.0;    ///< counter-clockwise about the z axis, 0 along the x axis
  double elevation_rad = 0.0;  ///< over the x-y plane
  Eigen::Matrix2d J_direction_pixel = Eigen::Matrix2d::Zero();  ///< of both by (u, v) [rad/px]
};

/// The azimuths that an image of this size shows at the horizon of the sensor's frame, or at the
/// nearest elevation up to 0.3 rad: their longest range, to half a degree. All around where it
/// shows them all, or none.
FieldOfView viewOf(const Camera& camera, int width_px, int height_px);

/// What a place in the image shows; none within a pixel of where the lens shows none.
std::optional<Direction> directionFromPixel(const Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace bearing_calibration::core
