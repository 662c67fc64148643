#pragma once

#include <Eigen/Core>
#include <optional>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// A camera that looks straight up into a cone whose apex points down at the lens. The sensor frame
/// has its origin in the apex, z up along the common axis, x forward, y left. Distances between the
/// axis and a light are horizontal, heights are counted from the apex.
///
/// A ray that leaves the lens at `ray angle` theta from the axis has the image radius
/// R = v tan(theta) / p (v image distance, p pixel pitch), meets the mirror at the hit radius
/// r = h / (cot theta - cot tau), and leaves it at 2 tau - theta from the axis.
struct ConicMirror {
  double focal_length_m = 0.0;
  double aperture_m = 0.0;        ///< diameter of the lens opening
  double focus_distance_m = 0.0;  ///< from the lens to the plane in focus; infinity is allowed
  double pixel_pitch_m = 0.0;
  double lens_to_apex_m = 0.0;  ///< h
  double half_angle_rad = 0.0;  ///< tau, between the axis and the cone's surface
  double base_radius_m = 0.0;   ///< of the mirror's rim

  void declare(Parameters& params);
};

/// Where the mirror's axis meets the image, and which way round the image is.
struct MirrorView {
  double centre_u_px = 0.0;  ///< column; integer values are pixel centres
  double centre_v_px = 0.0;  ///< row, growing downwards
  int handedness = 1;        ///< +1: azimuth grows counter-clockwise on the screen; -1: clockwise

  Eigen::Vector2d centre_px() const { return {centre_u_px, centre_v_px}; }
};

/// A pixel about the mirror's centre.
struct MirrorPixel {
  double image_radius_px = 0.0;
  double azimuth_rad = 0.0;  ///< in the sensor frame
};

/// A light beside the mirror.
struct LightPlace {
  double distance_m = 0.0;  ///< horizontal, from the axis
  double height_m = 0.0;    ///< above the apex; negative below it
};

/// Full widths of a point light's image through the open aperture. It is filled evenly, so its
/// standard deviation along each axis is a quarter of the width.
struct SpotBlur {
  double tangential_diameter_px = 0.0;
  double radial_diameter_px = 0.0;
};

/// First-order errors of the azimuth for errors of the rig. With w_t = -w_x sin(azimuth) +
/// w_y cos(azimuth) of each vector: error = tilt * alpha_t + offset * c_t + centre * u_t.
struct MisalignmentCoefficients {
  double tilt = 0.0;    ///< [rad/rad] alpha: the mirror's axis leans to (alpha_x, alpha_y, 1)
  double offset = 0.0;  ///< [rad/m] c: the apex beside the camera's axis
  double centre = 0.0;  ///< [rad/px] u: assumed centre minus principal point, in sensor axes
};

/// How a mirror that is tilted and stands beside the camera's axis bends the bearings of lights at
/// the range r: by a first harmonic of size F + N / r, whatever lean and offset are (model.md,
/// eq. 19). F shows in the bearings, N looks like a shifted sensor.
struct MirrorMisalignment {
  /// Where the image's centre is best put: this part of the way from the principal point to the
  /// centre of the mirror's rim. There, and nowhere else, N hangs on F alone.
  double centre_part = 0.0;
  double near_per_far_m = 0.0;  ///< N / F for a centre that was put there
};

MirrorPixel mirrorPixelFromImage(const MirrorView& view, double u_px, double v_px);
Eigen::Vector2d imageFromMirrorPixel(const MirrorView& view, const MirrorPixel& pixel);

/// v / p: image distance when focused at the focus distance, in pixels.
double imageDistancePx(const ConicMirror& mirror);

/// Elevation [rad] of the ray that leaves the mirror: 90 deg - 2 tau + theta.
double elevationFromRadius(const ConicMirror& mirror, double image_radius_px);
double radiusFromElevation(const ConicMirror& mirror, double elevation_rad);
/// d elevation / d image radius [rad/px].
double elevationSlope(const ConicMirror& mirror, double image_radius_px);

/// Image radius of the horizontal rays: a light below the apex lies inside. 0 when the mirror sees
/// nothing below the horizon.
double horizonRadiusPx(const ConicMirror& mirror);
double rimRadiusPx(const ConicMirror& mirror);

/// The image radius of a light, through the lens' centre; none for one too far below or above to be
/// seen in the mirror.
std::optional<double> radiusFromLight(const ConicMirror& mirror, const LightPlace& light);

/// Whether a light at `image_radius_px` and horizontal distance `distance_m` from the axis lies
/// outside of the mirror.
bool showsOutside(const ConicMirror& mirror, double image_radius_px, double distance_m);

/// Its blur.
/// @throws std::invalid_argument when the light would lie inside the mirror.
SpotBlur expectedBlur(const ConicMirror& mirror, double image_radius_px, double distance_m);

MisalignmentCoefficients misalignment(const ConicMirror& mirror, const LightPlace& light);

/// @param height_m  of the lights above the mirror's apex
/// @param least_distance_m, most_distance_m  of the lights from the mirror's axis: the harmonic
///   follows F + N / r exactly at both, and within some percent between them
/// @throws std::invalid_argument when the distances are not 0 < least < most, or the mirror sees no
///   light at them
MirrorMisalignment mirrorMisalignment(const ConicMirror& mirror, double height_m,
                                      double least_distance_m, double most_distance_m);

}  // namespace bearing_calibration::core
