#include "bearing_calibration/record/observation_path.h"

#include "bearing_calibration/record/observation_record.h"

namespace bearing_calibration::core {

std::vector<PosedObservation> poseObservations(const std::vector<Observation>& observations) {
  std::vector<PosedObservation> posed;
  posed.reserve(observations.size());
  PosedObservation now;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (i > 0) {
      const OdometryIncrement& motion = observations[i].motion;
      now.first_from_base = now.first_from_base * motion.start_from_end;
      now.heading_variance_rad2 += motion.covariance(2, 2);
      now.position_variance_m2 += 0.5 * motion.covariance.topLeftCorner<2, 2>().trace();
    }
    now.azimuth_rad = observations[i].azimuth_rad;
    now.azimuth_variance_rad2 = observations[i].azimuth_variance_rad2;
    posed.push_back(now);
  }
  return posed;
}

std::vector<Observation> thinned(const std::vector<Observation>& observations,
                                 std::size_t max_observations) {
  if (observations.size() <= max_observations) return observations;
  ObservationRecordConfig config;
  config.capacity = max_observations;
  ObservationRecord record(config);
  for (const Observation& observation : observations) record.add(observation);
  return record.observations();
}

}  // namespace bearing_calibration::core
