#include "bearing_calibration/optics/mirror_misalignment.h"

#include <Eigen/Core>
#include <cmath>
#include <stdexcept>

namespace bearing_calibration::core {
namespace {

/// Size of a harmonic of lights at the range r: far + near / r.
struct Harmonic {
  double far = 0.0;
  double near = 0.0;
};

/// The harmonic that has these sizes at two distances.
Harmonic through(const Eigen::Vector2d& distances_m, const Eigen::Vector2d& sizes) {
  const Eigen::Vector2d nearness = distances_m.cwiseInverse();
  Harmonic harmonic;
  harmonic.near = (sizes(1) - sizes(0)) / (nearness(1) - nearness(0));
  harmonic.far = sizes(0) - harmonic.near * nearness(0);
  return harmonic;
}

/// How far the rim's centre lies from the principal point [px], for a lean and for an offset of 1.
struct RimShift {
  double lean_px;
  double offset_px_m;
};

RimShift rimShift(const ConicMirror& mirror) {
  const double R = mirror.base_radius_m;
  const double rim_over_apex_m = R / std::tan(mirror.half_angle_rad);
  const double d = mirror.lens_to_apex_m + rim_over_apex_m;
  const double scale_px = imageDistancePx(mirror);
  // The rim is carried along by the lean, and its nearer side looks larger.
  return {scale_px * (rim_over_apex_m / d + R * R / (d * d)), scale_px / d};
}

}  // namespace

MirrorMisalignment mirrorMisalignment(const ConicMirror& mirror, double height_m,
                                      double least_distance_m, double most_distance_m) {
  if (!(least_distance_m > 0.0 && most_distance_m > least_distance_m)) {
    throw std::invalid_argument("the lights' least distance must be between 0 and the largest one");
  }
  const Eigen::Vector2d distances_m(least_distance_m, most_distance_m);
  Eigen::Vector2d leans, offsets, centres;
  for (int i = 0; i < 2; ++i) {
    const LightPlace light{distances_m(i), height_m};
    if (!radiusFromLight(mirror, light)) {
      throw std::invalid_argument("the mirror does not see lights at this height and distance");
    }
    const MisalignmentCoefficients coefficients = misalignment(mirror, light);
    leans(i) = coefficients.tilt;
    offsets(i) = coefficients.offset;
    centres(i) = coefficients.centre;
  }
  const Harmonic lean = through(distances_m, leans);
  const Harmonic offset = through(distances_m, offsets);
  const Harmonic centre = through(distances_m, centres);
  const RimShift rim = rimShift(mirror);

  // With the centre at part k of the way, lean and offset make
  //   F = lean.far + k rim.lean centre.far,  N = lean.near + k rim.lean centre.near,  and alike.
  // Both have the same N / F at the k where their determinant is zero; k^2 drops out of it.
  const double cross_lean = lean.far * centre.near - lean.near * centre.far;
  const double cross_offset = offset.far * centre.near - offset.near * centre.far;
  const double cross = lean.near * offset.far - lean.far * offset.near;
  MirrorMisalignment bend;
  bend.centre_part = cross / (rim.offset_px_m * cross_lean - rim.lean_px * cross_offset);
  const double lean_centre = bend.centre_part * rim.lean_px;
  const double offset_centre = bend.centre_part * rim.offset_px_m;
  const Eigen::Vector2d far(lean.far + lean_centre * centre.far,
                            offset.far + offset_centre * centre.far);
  const Eigen::Vector2d near(lean.near + lean_centre * centre.near,
                             offset.near + offset_centre * centre.near);
  bend.near_per_far_m = near(0) / far(0);
  return bend;
}

}  // namespace bearing_calibration::core
