#include "bearing_calibration/calibration/sight_path.h"

namespace bearing_calibration {

std::vector<PosedSight> poseSights(const std::vector<Sight>& sights) {
  std::vector<PosedSight> posed;
  posed.reserve(sights.size());
  PosedSight now;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (i > 0) {
      const OdometryIncrement& motion = sights[i].motion;
      now.first_from_base = now.first_from_base * motion.start_from_end;
      now.heading_variance_rad2 += motion.covariance(2, 2);
      now.position_variance_m2 += 0.5 * motion.covariance.topLeftCorner<2, 2>().trace();
    }
    now.azimuth_rad = sights[i].azimuth_rad;
    now.azimuth_variance_rad2 = sights[i].azimuth_variance_rad2;
    posed.push_back(now);
  }
  return posed;
}

std::vector<Sight> thinned(const std::vector<Sight>& sights, std::size_t max_sights) {
  if (sights.size() <= max_sights) return sights;
  const std::size_t step = (sights.size() + max_sights - 1) / max_sights;
  std::vector<Sight> kept;
  OdometryIncrement motion;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    motion = append(motion, sights[i].motion);
    // counted from the end, so that the last one is kept
    if ((sights.size() - 1 - i) % step != 0) continue;
    kept.push_back(sights[i]);
    kept.back().motion = motion;
    motion = {};
  }
  return kept;
}

}  // namespace bearing_calibration
