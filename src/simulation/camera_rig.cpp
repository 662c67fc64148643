#include "bearing_calibration/simulation/camera_rig.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// One of the two straight pieces of a light's path, seen from the mirror.
struct PathPiece {
  PathPiece(const Vector3d& end, const Vector3d& mirror_point)
      : length((mirror_point - end).norm()), direction((mirror_point - end) / length) {}
  double length;
  Vector3d direction;  ///< from its outer end to the mirror
};

namespace {

/// Second derivative of |M - X| when M moves along a and b: (a.b - (u.a)(u.b)) / |M - X|.
double lengthCurvature(const PathPiece& piece, const Vector3d& a, const Vector3d& b) {
  return (a.dot(b) - piece.direction.dot(a) * piece.direction.dot(b)) / piece.length;
}

Vector3d outwardAt(double azimuth_rad) {
  return {std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0};
}

}  // namespace

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

/// A point of the cone in the mirror's frame (apex at the origin, axis up) with the length F of the
/// path light - point - lens, differentiated by its distance from the apex and its azimuth.
struct ConeTracer::SurfacePoint {
  SurfacePoint(const ConeTracer& cone, double along_m, const Vector3d& outward,
               const Vector3d& light, const Vector3d& lens);

  Vector3d tangent_along;    ///< d position / d along
  Vector3d tangent_azimuth;  ///< d position / d azimuth
  Vector3d position;
  PathPiece from_light;
  PathPiece from_lens;
  Vector2d gradient;  ///< of F; zero where the law of reflection holds
  Matrix2d hessian;   ///< of F
};

ConeTracer::SurfacePoint::SurfacePoint(const ConeTracer& cone, double along_m,
                                       const Vector3d& outward, const Vector3d& light,
                                       const Vector3d& lens)
    : tangent_along(cone.along(outward)),
      position(along_m * tangent_along),
      from_light(light, position),
      from_lens(lens, position) {
  const Vector3d around(-outward.y(), outward.x(), 0.0);
  tangent_azimuth = along_m * cone.sin_tau_ * around;
  // d^2 position / d along d azimuth and d^2 position / d azimuth^2; along itself is straight.
  const Vector3d bend_mixed = cone.sin_tau_ * around;
  const Vector3d bend_azimuth = -along_m * cone.sin_tau_ * outward;
  const Vector3d pull = from_light.direction + from_lens.direction;
  const auto curvature = [this](const Vector3d& a, const Vector3d& b) {
    return lengthCurvature(from_light, a, b) + lengthCurvature(from_lens, a, b);
  };
  gradient << pull.dot(tangent_along), pull.dot(tangent_azimuth);
  const double mixed = curvature(tangent_along, tangent_azimuth) + pull.dot(bend_mixed);
  hessian << curvature(tangent_along, tangent_along), mixed, mixed,
      curvature(tangent_azimuth, tangent_azimuth) + pull.dot(bend_azimuth);
}

ConeTracer::ConeTracer(const CameraRig& rig)
    : rig_(validated(rig)),
      sin_tau_(std::sin(rig.cone_half_angle_rad)),
      cos_tau_(std::cos(rig.cone_half_angle_rad)),
      apex_(rig.apex_offset_m.x(), rig.apex_offset_m.y(), 0.0) {
  const Vector3d turn(-rig.axis_lean.y(), rig.axis_lean.x(), 0.0);  // of the axis from upright
  sensor_from_mirror_rotation_ =
      Eigen::AngleAxisd(std::atan(turn.norm()), turn.normalized()).toRotationMatrix();
}

Vector3d ConeTracer::along(const Vector3d& outward) const {
  return sin_tau_ * outward + Vector3d(0.0, 0.0, cos_tau_);
}

Vector3d ConeTracer::inMirror(const Vector3d& point) const {
  return sensor_from_mirror_rotation_.transpose() * (point - apex_);
}

std::optional<ConeTracer::SurfacePoint> ConeTracer::reflectionPoint(const Vector3d& light,
                                                                    const Vector3d& lens) const {
  constexpr int kMaxSteps = 12;         // four do from the start below; more is divergence
  constexpr double kConverged = 1e-10;  // of a step, relative to the cone: 1e-8 of a pixel
  // Start: in the plane through axis and light the cone is a straight mirror, and the ray divides
  // it in the ratio of the two ends' distances from it. Exact when the lens point is on the axis.
  double azimuth = std::atan2(light.y(), light.x());
  const Vector3d outward = outwardAt(azimuth);
  const Vector3d surface = along(outward);
  const Vector3d normal = cos_tau_ * outward - Vector3d(0.0, 0.0, sin_tau_);
  const double light_height = normal.dot(light);
  const double lens_height = normal.dot(lens);
  if (light_height <= 0.0 || lens_height <= 0.0) return std::nullopt;  // behind the mirror
  double along_m = (surface.dot(light) * lens_height + surface.dot(lens) * light_height) /
                   (light_height + lens_height);
  for (int i = 0; i < kMaxSteps && along_m > 0.0; ++i) {
    const SurfacePoint point(*this, along_m, outwardAt(azimuth), light, lens);
    const Vector2d step = -point.hessian.inverse() * point.gradient;
    if (std::abs(step(0)) < kConverged * along_m && std::abs(step(1)) < kConverged) {
      if (along_m * sin_tau_ > rig_.mirror_radius_m) return std::nullopt;
      return point;
    }
    along_m += step(0);
    azimuth += step(1);
  }
  return std::nullopt;
}

double ConeTracer::throughput(const SurfacePoint& point) const {
  // The point stays stationary when the lens point moves: hessian * d point = -d gradient.
  Matrix2d J_gradient_lens;
  for (int i = 0; i < 2; ++i) {
    const Vector3d move = sensor_from_mirror_rotation_.row(i).transpose();
    J_gradient_lens(0, i) = -lengthCurvature(point.from_lens, point.tangent_along, move);
    J_gradient_lens(1, i) = -lengthCurvature(point.from_lens, point.tangent_azimuth, move);
  }
  const Matrix2d J_point_lens = -point.hessian.inverse() * J_gradient_lens;
  const double mirror_area_per_lens_area =
      std::abs(J_point_lens.determinant() *
               point.tangent_along.cross(point.tangent_azimuth).dot(point.from_light.direction));
  return mirror_area_per_lens_area / (point.from_light.length * point.from_light.length);
}

std::optional<ConeTracer::SensorHit> ConeTracer::rayFrom(const Vector3d& light_m,
                                                         const Vector2d& aperture_m) const {
  const Vector3d lens_point(aperture_m.x(), aperture_m.y(), -rig_.lens_to_apex_m);
  const auto point = reflectionPoint(inMirror(light_m), inMirror(lens_point));
  if (!point) return std::nullopt;
  const Vector3d to_mirror = sensor_from_mirror_rotation_ * point->position + apex_ - lens_point;
  // All rays through one point of the sharp plane meet in one point of the image (thin lens).
  const Vector2d sharp_slope =
      aperture_m / rig_.focus_distance_m + to_mirror.head<2>() / to_mirror.z();
  const Vector2d image(sharp_slope.x(), -rig_.handedness * sharp_slope.y());
  return SensorHit{rig_.centre_px + rig_.pixelsPerSlope() * image, throughput(*point)};
}

std::optional<Vector3d> ConeTracer::directionSeenBy(const Vector2d& pixel) const {
  const Vector2d image = (pixel - rig_.centre_px) / rig_.pixelsPerSlope();
  const Vector3d ray = sensor_from_mirror_rotation_.transpose() *
                       Vector3d(image.x(), -rig_.handedness * image.y(), 1.0);
  const Vector3d lens = inMirror({0.0, 0.0, -rig_.lens_to_apex_m});
  // Nearest point of the cone z^2 sin^2 = (x^2 + y^2) cos^2 with z > 0 on the line lens + t ray.
  const Vector3d weights(-cos_tau_ * cos_tau_, -cos_tau_ * cos_tau_, sin_tau_ * sin_tau_);
  const double a = ray.dot(weights.cwiseProduct(ray));
  const double b = ray.dot(weights.cwiseProduct(lens));
  const double c = lens.dot(weights.cwiseProduct(lens));
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0 || a == 0.0) return std::nullopt;
  const double t = (-b + std::sqrt(discriminant)) / a;
  const Vector3d hit = lens + t * ray;
  const double radius = hit.head<2>().norm();
  if (t <= 0.0 || hit.z() <= 0.0 || radius == 0.0 || radius > rig_.mirror_radius_m) {
    return std::nullopt;
  }
  const Vector3d normal(cos_tau_ * hit.x() / radius, cos_tau_ * hit.y() / radius, -sin_tau_);
  const Vector3d reflected = ray - 2.0 * ray.dot(normal) * normal;
  return sensor_from_mirror_rotation_ * reflected.normalized();
}

}  // namespace bearing_calibration::core
