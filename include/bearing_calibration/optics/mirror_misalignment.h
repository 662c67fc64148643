#pragma once

#include "bearing_calibration/optics/conic_mirror.h"

namespace bearing_calibration::core {

/// How a mirror that is tilted and stands beside the camera's axis bends the bearings of lights at
/// the range r: by a first harmonic of size F + N / r, whatever lean and offset are (doc/model.md,
/// eq. 19). F shows in the bearings, N looks like a shifted sensor.
struct MirrorMisalignment {
  /// Where the image's centre is best put: this part of the way from the principal point to the
  /// centre of the mirror's rim. There, and nowhere else, N hangs on F alone.
  double centre_part = 0.0;
  double near_per_far_m = 0.0;  ///< N / F for a centre that was put there
};

/// @param height_m  of the lights above the mirror's apex
/// @param least_distance_m, most_distance_m  of the lights from the mirror's axis: the harmonic
///   follows F + N / r exactly at both, and within some percent between them
/// @throws std::invalid_argument when the distances are not 0 < least < most, or the mirror sees no
///   light at them
MirrorMisalignment mirrorMisalignment(const ConicMirror& mirror, double height_m,
                                      double least_distance_m, double most_distance_m);

}  // namespace bearing_calibration::core
