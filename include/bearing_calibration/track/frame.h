#pragma once

#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// An image, and how the base has moved to where it was taken.
struct Frame {
  BearingSet image;
  OdometryIncrement motion;  ///< since the image before
  OdometryWindow nearby;     ///< the wheels' travel around the image's stamp
};

}  // namespace bearing_calibration::core
