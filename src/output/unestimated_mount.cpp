#include "bearing_calibration/output/unestimated_mount.h"

namespace bearing_calibration::core {

void UnestimatedMount::declare(Parameters& params) {
  using namespace plausible;
  params.number("mount/z", z_m, -kFarthest_m, kFarthest_m);
  params.number("mount/roll", roll_rad, -kPi, kPi);
  params.number("mount/pitch", pitch_rad, -0.5 * kPi, 0.5 * kPi);
  params.number("mount/z_stddev", z_stddev_m, kLeastLength_m, kFarthest_m);
  params.number("mount/roll_stddev", roll_stddev_rad, kLeastAngle_rad, kTurn_rad);
  params.number("mount/pitch_stddev", pitch_stddev_rad, kLeastAngle_rad, kTurn_rad);
}

}  // namespace bearing_calibration::core
