#include "bearing_calibration/output/unestimated_mount.h"

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration::core {

std::vector<std::string> UnestimatedMount::validate() const {
  Requirements require;
  require.between("mount/z", z_m, -plausible::kFarthest_m, plausible::kFarthest_m);
  require.between("mount/roll", roll_rad, -kPi, kPi);
  require.between("mount/pitch", pitch_rad, -0.5 * kPi, 0.5 * kPi);
  require.between("mount/z_stddev", z_stddev_m, plausible::kLeastLength_m, plausible::kFarthest_m);
  require.between("mount/roll_stddev", roll_stddev_rad, plausible::kLeastAngle_rad,
                  plausible::kTurn_rad);
  require.between("mount/pitch_stddev", pitch_stddev_rad, plausible::kLeastAngle_rad,
                  plausible::kTurn_rad);
  return require.errors();
}

}  // namespace bearing_calibration::core
