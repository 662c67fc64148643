#pragma once

#include <functional>
#include <limits>

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {

/// An image, and how the base has moved to where it was taken.
struct Frame {
  BearingSet image;
  OdometryIncrement motion;  ///< since the image before
  OdometryWindow nearby;     ///< the wheels' travel around the image's stamp
};

/// What became of one image in a calibration: for reports, beside the estimate.
struct AssociationOutcome {
  /// A light that is found is fused, or collected before there is a filter.
  Association::Kind kind = Association::Kind::kNothingSeen;
  /// On the encoders' clock; the motion is since the image before. The bearing is that of the
  /// likeliest candidate; NaN where nothing was seen.
  Observation observation;
  bool lost_light = false;  ///< everything before this image was given up

  /// Of an image in which nothing was seen so far.
  static AssociationOutcome of(const Frame& frame) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    AssociationOutcome outcome;
    outcome.observation = {frame.image.stamp, frame.motion, kNone, kNone, frame.nearby};
    return outcome;
  }

  void note(Association::Kind what, const Bearing& light) {
    kind = what;
    observation.azimuth_rad = light.azimuth_rad;
    observation.azimuth_variance_rad2 = light.azimuth_variance_rad2;
    observation.elevation = elevationOf(light);
  }
};

using OutcomeObserver = std::function<void(const AssociationOutcome&)>;

}  // namespace bearing_calibration::core
