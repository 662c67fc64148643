#include "bearing_calibration/track/recent_innovations.h"

namespace bearing_calibration::core {

Consistency RecentInnovations::consistency() const {
  Consistency consistency;
  for (double nis : nis_) {
    if (nis == kNotFused) {
      ++consistency.not_fused;
      continue;
    }
    ++consistency.fused;
    consistency.nis = nis;
    consistency.nis_mean += nis;
  }
  if (consistency.fused > 0) consistency.nis_mean /= consistency.fused;
  return consistency;
}

}  // namespace bearing_calibration::core
