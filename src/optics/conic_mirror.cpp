#include "bearing_calibration/optics/conic_mirror.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

double cot(double angle_rad) { return 1.0 / std::tan(angle_rad); }

/// Horizontal distance from the axis at which a ray meets the mirror [m].
double hitRadius(const ConicMirror& mirror, double ray_angle_rad) {
  // h / (cot theta - cot tau), written so that the ray along the axis gives 0.
  const double tangent = std::tan(ray_angle_rad);
  return mirror.lens_to_apex_m * tangent / (1.0 - tangent * cot(mirror.half_angle_rad));
}

/// Angle of the reflected ray from the upward axis [rad].
double exitAngle(const ConicMirror& mirror, double ray_angle_rad) {
  return 2.0 * mirror.half_angle_rad - ray_angle_rad;
}

/// The path from the lens over the mirror to a light, all in one plane through the axis.
struct LightPath {
  double hit_radius_m;       ///< r
  double lens_to_mirror_m;   ///< s1
  double mirror_to_light_m;  ///< s2
};

/// Not positive for a light inside of the mirror.
double mirrorToLight(const ConicMirror& mirror, double ray_angle_rad, double distance_m) {
  return (distance_m - hitRadius(mirror, ray_angle_rad)) /
         std::sin(exitAngle(mirror, ray_angle_rad));
}

LightPath pathToDistance(const ConicMirror& mirror, double ray_angle_rad, double distance_m) {
  const double hit_radius_m = hitRadius(mirror, ray_angle_rad);
  const double lens_to_mirror_m =
      std::hypot(hit_radius_m, mirror.lens_to_apex_m + hit_radius_m * cot(mirror.half_angle_rad));
  const double mirror_to_light_m = mirrorToLight(mirror, ray_angle_rad, distance_m);
  if (!(mirror_to_light_m > 0.0)) {
    throw std::invalid_argument("a light at " + std::to_string(distance_m) +
                                " m from the axis lies inside the mirror");
  }
  return {hit_radius_m, lens_to_mirror_m, mirror_to_light_m};
}

/// In a plane through the axis the cone is a plane mirror: the light appears at its reflection in
/// the cone's surface line.
double rayAngleFromLight(const ConicMirror& mirror, const LightPlace& light) {
  const double apex_to_light_m = std::hypot(light.distance_m, light.height_m);
  const double virtual_angle_rad =
      2.0 * mirror.half_angle_rad - std::atan2(light.distance_m, light.height_m);
  return std::atan2(apex_to_light_m * std::sin(virtual_angle_rad),
                    mirror.lens_to_apex_m + apex_to_light_m * std::cos(virtual_angle_rad));
}

double vergence(double distance_m) { return 1.0 / distance_m; }

double rayAngleFromRadius(const ConicMirror& mirror, double image_radius_px) {
  return std::atan(image_radius_px / imageDistancePx(mirror));
}

double radiusFromRayAngle(const ConicMirror& mirror, double ray_angle_rad) {
  return imageDistancePx(mirror) * std::tan(ray_angle_rad);
}

/// How far the rim's centre lies from the principal point, for a lean and for an offset of 1
/// [px/rad, px/m].
Eigen::Vector2d rimShift(const ConicMirror& mirror) {
  const double R = mirror.base_radius_m;
  const double rim_over_apex_m = R * cot(mirror.half_angle_rad);
  const double d = mirror.lens_to_apex_m + rim_over_apex_m;
  // The rim is carried along by the lean, and its nearer side looks larger.
  return imageDistancePx(mirror) * Eigen::Vector2d(rim_over_apex_m / d + R * R / (d * d), 1.0 / d);
}

}  // namespace

void ConicMirror::declare(Parameters& params) {
  // A narrower cone sees only the sky, a wider one only the robot itself.
  constexpr double kMinHalfAngleRad = 30.0 / kDegreesPerRadian;
  constexpr double kMaxHalfAngleRad = 80.0 / kDegreesPerRadian;
  constexpr double kLeastOfALens_m = 1e-6;
  constexpr double kLargestOfALens_m = 10.0;  // and of a mirror
  constexpr double kSmallestPixel_m = 1e-8;
  constexpr double kLargestPixel_m = 1e-2;
  constexpr double kInfinity_m = 1e6;  // to focus on
  params.number("lens/focal_length", focal_length_m, kLeastOfALens_m, kLargestOfALens_m);
  params.number("lens/aperture", aperture_m, kLeastOfALens_m, kLargestOfALens_m);
  params.number("lens/pixel_pitch", pixel_pitch_m, kSmallestPixel_m, kLargestPixel_m);
  params.read("lens/focus_distance", focus_distance_m);
  params.that(focus_distance_m > focal_length_m &&
                  (focus_distance_m <= kInfinity_m || std::isinf(focus_distance_m)),
              "lens/focus_distance must be greater than lens/focal_length and at most " +
                  formatted("%g, but is %.9g", kInfinity_m, focus_distance_m));
  params.number("mirror/lens_to_apex", lens_to_apex_m, kLeastOfALens_m, kLargestOfALens_m);
  params.number("mirror/half_angle", half_angle_rad, kMinHalfAngleRad, kMaxHalfAngleRad);
  params.number("mirror/base_radius", base_radius_m, kLeastOfALens_m, kLargestOfALens_m);
}

MirrorPixel mirrorPixelFromImage(const MirrorView& view, double u_px, double v_px) {
  const double right = u_px - view.centre_u_px;
  const double up = -(v_px - view.centre_v_px);
  return {std::sqrt(right * right + up * up), view.handedness * std::atan2(up, right)};
}

Eigen::Vector2d imageFromMirrorPixel(const MirrorView& view, const MirrorPixel& pixel) {
  const double screen_angle = view.handedness * pixel.azimuth_rad;
  return {view.centre_u_px + pixel.image_radius_px * std::cos(screen_angle),
          view.centre_v_px - pixel.image_radius_px * std::sin(screen_angle)};
}

double imageDistancePx(const ConicMirror& mirror) {
  const double image_vergence = vergence(mirror.focal_length_m) - vergence(mirror.focus_distance_m);
  return 1.0 / (image_vergence * mirror.pixel_pitch_m);
}

double elevationFromRadius(const ConicMirror& mirror, double image_radius_px) {
  return 0.5 * kPi - exitAngle(mirror, rayAngleFromRadius(mirror, image_radius_px));
}

double radiusFromElevation(const ConicMirror& mirror, double elevation_rad) {
  return radiusFromRayAngle(mirror, elevation_rad - 0.5 * kPi + 2.0 * mirror.half_angle_rad);
}

double elevationSlope(const ConicMirror& mirror, double image_radius_px) {
  const double distance_px = imageDistancePx(mirror);
  return distance_px / (distance_px * distance_px + image_radius_px * image_radius_px);
}

double horizonRadiusPx(const ConicMirror& mirror) {
  return std::max(0.0, radiusFromElevation(mirror, 0.0));
}

double rimRadiusPx(const ConicMirror& mirror) {
  const double rim_height_m =
      mirror.lens_to_apex_m + mirror.base_radius_m * cot(mirror.half_angle_rad);
  return imageDistancePx(mirror) * mirror.base_radius_m / rim_height_m;
}

std::optional<double> radiusFromLight(const ConicMirror& mirror, const LightPlace& light) {
  const double radius_px = radiusFromRayAngle(mirror, rayAngleFromLight(mirror, light));
  const bool seen = radius_px > 0.0 && radius_px <= rimRadiusPx(mirror);
  return seen ? std::optional<double>(radius_px) : std::nullopt;
}

bool showsOutside(const ConicMirror& mirror, double image_radius_px, double distance_m) {
  const double theta = rayAngleFromRadius(mirror, image_radius_px);
  const bool meets_mirror = hitRadius(mirror, theta) >= 0.0;  // not along its surface
  return meets_mirror && mirrorToLight(mirror, theta, distance_m) > 0.0;
}

SpotBlur expectedBlur(const ConicMirror& mirror, double image_radius_px, double distance_m) {
  const double theta = rayAngleFromRadius(mirror, image_radius_px);
  const LightPath path = pathToDistance(mirror, theta, distance_m);
  // Along the azimuth the cone is a convex mirror (Coddington's sagittal equation).
  const double mirror_power =
      (std::sin(exitAngle(mirror, theta)) - std::sin(theta)) / path.hit_radius_m;
  const double sagittal_m = 1.0 / (vergence(path.mirror_to_light_m) + mirror_power);
  // Depth along the lens' axis at which each section's rays seem to meet.
  const double tangential_depth_m = (path.lens_to_mirror_m + sagittal_m) * std::cos(theta);
  const double radial_depth_m = (path.lens_to_mirror_m + path.mirror_to_light_m) * std::cos(theta);
  const double blur_px_m = mirror.aperture_m * imageDistancePx(mirror);
  const double focus = vergence(mirror.focus_distance_m);
  return {blur_px_m * std::abs(focus - vergence(tangential_depth_m)),
          blur_px_m * std::abs(focus - vergence(radial_depth_m))};
}

MisalignmentCoefficients misalignment(const ConicMirror& mirror, const LightPlace& light) {
  const double theta = rayAngleFromLight(mirror, light);
  const LightPath path = pathToDistance(mirror, theta, light.distance_m);
  const double D = light.distance_m;
  const double sagittal_curvature =
      (1.0 - path.mirror_to_light_m * std::sin(theta) / D) / path.hit_radius_m;
  return {2.0 * (cot(mirror.half_angle_rad) - light.height_m / D), sagittal_curvature - vergence(D),
          -1.0 / radiusFromRayAngle(mirror, theta)};
}

MirrorMisalignment mirrorMisalignment(const ConicMirror& mirror, double height_m,
                                      double least_distance_m, double most_distance_m) {
  if (!(least_distance_m > 0.0 && most_distance_m > least_distance_m)) {
    throw std::invalid_argument("the lights' least distance must be between 0 and the largest one");
  }
  const auto coefficientsAt = [&](double distance_m) -> Eigen::Vector3d {
    const LightPlace light{distance_m, height_m};
    if (!radiusFromLight(mirror, light)) {
      throw std::invalid_argument("the mirror does not see lights at this height and distance");
    }
    const MisalignmentCoefficients coefficients = misalignment(mirror, light);
    return {coefficients.tilt, coefficients.offset, coefficients.centre};
  };
  // Of each coefficient (lean, offset, centre): far + near / r.
  const Eigen::Vector3d at_least = coefficientsAt(least_distance_m);
  const Eigen::Vector3d at_most = coefficientsAt(most_distance_m);
  const Eigen::Vector3d near =
      (at_most - at_least) / (vergence(most_distance_m) - vergence(least_distance_m));
  const Eigen::Vector3d far = at_least - near * vergence(least_distance_m);

  // With the centre at part k of the way, lean (and alike the offset) makes
  //   F = far.lean + k rim.lean far.centre,  N = near.lean + k rim.lean near.centre.
  // Both have the same N / F at the k where their determinant is zero; k^2 drops out of it.
  const Eigen::Vector2d rim = rimShift(mirror);
  const Eigen::Vector3d cross = far.cross(near);
  const double centre_part = cross(2) / (rim(0) * cross(0) + rim(1) * cross(1));
  const double lean_centre = centre_part * rim(0);
  return {centre_part, (near(0) + lean_centre * near(2)) / (far(0) + lean_centre * far(2))};
}

}  // namespace bearing_calibration::core
