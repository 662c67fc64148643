#include "support/cone_ray_trace.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace bearing_calibration::core {
namespace test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The cone {q: (q - apex).axis = |q - apex| cos(tau)}.
struct Cone {
  Vector3d apex_m;
  Vector3d axis;
  double cos_tau;
};

/// A ray's first hit of the cone: the quadratic ((q - apex).axis)^2 = cos^2 |q - apex|^2.
Vector3d hit(const Cone& cone, const Vector3d& start_m, const Vector3d& direction) {
  const Vector3d m = start_m - cone.apex_m;
  const double c2 = cone.cos_tau * cone.cos_tau;
  const double da = direction.dot(cone.axis);
  const double ma = m.dot(cone.axis);
  const double a = da * da - c2 * direction.squaredNorm();
  const double b = da * ma - c2 * direction.dot(m);
  const double c = ma * ma - c2 * m.squaredNorm();
  const double root = std::sqrt(b * b - a * c);
  double best = std::numeric_limits<double>::infinity();
  for (double t : {(-b - root) / a, (-b + root) / a}) {
    if (t > 0.0 && ma + t * da > 0.0) best = std::min(best, t);
  }
  if (!std::isfinite(best)) throw std::runtime_error("the ray misses the cone");
  return start_m + best * direction;
}

Vector3d reflect(const Cone& cone, const Vector3d& point_m, const Vector3d& direction) {
  const Vector3d from_apex = point_m - cone.apex_m;
  const Vector3d normal = (cone.axis - cone.cos_tau * from_apex.normalized()).normalized();
  return direction - 2.0 * direction.dot(normal) * normal;
}

/// Where the reflected ray passes the light: its distance from it in two directions across.
Vector2d miss(const Cone& cone, const Vector3d& start_m, const Vector2d& slope,
              const Vector3d& light_m) {
  const Vector3d direction(slope.x(), slope.y(), 1.0);
  const Vector3d on_mirror = hit(cone, start_m, direction);
  const Vector3d out = reflect(cone, on_mirror, direction);
  const Vector3d side = Vector3d::UnitZ().cross(light_m).normalized();
  const Vector3d across = side.cross(light_m).normalized();
  const double t = (light_m - on_mirror).dot(light_m) / out.dot(light_m);
  const Vector3d gap = on_mirror + t * out - light_m;
  return {gap.dot(side), gap.dot(across)};
}

}  // namespace

Vector2d traceToImage(const ConicMirror& mirror, const ConeMisalignment& misalignment,
                      const Vector3d& light_m, const Vector2d& aperture_m) {
  const Cone cone{{misalignment.offset_m.x(), misalignment.offset_m.y(), 0.0},
                  Vector3d(misalignment.tilt.x(), misalignment.tilt.y(), 1.0).normalized(),
                  std::cos(mirror.half_angle_rad)};
  const Vector3d start_m(aperture_m.x(), aperture_m.y(), -mirror.lens_to_apex_m);
  constexpr double kFirstSlope = 0.2;  // some ray inside the mirror's image
  Vector2d slope = kFirstSlope * light_m.head<2>().normalized();
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Vector2d error = miss(cone, start_m, slope, light_m);
    constexpr double kStep = 1e-6;
    Eigen::Matrix2d J;
    for (int i = 0; i < 2; ++i) {
      const Vector2d step = kStep * Vector2d::Unit(i);
      J.col(i) = (miss(cone, start_m, slope + step, light_m) -
                  miss(cone, start_m, slope - step, light_m)) /
                 (2.0 * kStep);
    }
    const Vector2d change = J.fullPivLu().solve(error);
    // Short steps keep the ray on the mirror.
    constexpr double kLongest = 0.03;
    slope -= change * std::min(1.0, kLongest / (change.norm() + 1e-300));
    if (change.norm() < 1e-13) {
      // Thin lens: all rays through one point of the plane in focus meet in one point of the image.
      const double image_m = 1.0 / (1.0 / mirror.focal_length_m - 1.0 / mirror.focus_distance_m);
      return image_m / mirror.pixel_pitch_m * (aperture_m / mirror.focus_distance_m + slope);
    }
  }
  throw std::runtime_error("no ray found from the light over the cone to the aperture");
}

}  // namespace test
}  // namespace bearing_calibration::core
