#include "bearing_calibration/calibration/unestimated_mount.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration {

std::vector<std::string> UnestimatedMount::validate() const {
  Requirements require;
  require.that(std::isfinite(z_m), "mount/z must be finite");
  require.between("mount/roll", roll_rad, -kPi, kPi);
  require.between("mount/pitch", pitch_rad, -0.5 * kPi, 0.5 * kPi);
  require.positive("mount/z_stddev", z_stddev_m);
  require.positive("mount/roll_stddev", roll_stddev_rad);
  require.positive("mount/pitch_stddev", pitch_stddev_rad);
  return require.errors();
}

}  // namespace bearing_calibration
