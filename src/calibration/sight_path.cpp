#include "bearing_calibration/calibration/sight_path.h"

#include "bearing_calibration/calibration/sight_record.h"

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
  SightRecordConfig config;
  config.capacity = max_sights;
  SightRecord record(config);
  for (const Sight& sight : sights) record.add(sight);
  return record.sights();
}

}  // namespace bearing_calibration
