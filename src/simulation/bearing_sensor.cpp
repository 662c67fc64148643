#include "bearing_calibration/simulation/bearing_sensor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
void BearingSensorConfig::declare(Parameters& params) {
  constexpr double kLargestCorrelation = 0.9999;  // 1 is a constant error, not noise
  params.notNegative("sensor/stddev", stddev_rad);
  params.notNegative("sensor/elevation_stddev", elevation_stddev_rad);
  for (double angle_rad : {roll_rad, pitch_rad, harmonic_cos_rad, harmonic_sin_rad}) {
    params.that(std::isfinite(angle_rad), "the sensor's tilt and harmonic must be finite");
  }
  params.between("sensor/correlation", correlation, 0.0, kLargestCorrelation);
  params.between("sensor/outlier_probability", outlier_probability, 0.0, 1.0);
  params.between("sensor/miss_probability", miss_probability, 0.0, 1.0);
}

BearingSensor::BearingSensor(const BearingSensorConfig& config, std::uint64_t seed)
    : config_(validated(config)),
      noise_(seed, RandomStream::Purpose::kBearings),
      faults_(seed, RandomStream::Purpose::kFaults),
      elevation_noise_(seed, RandomStream::Purpose::kElevations) {}

double BearingSensor::nextNoise(std::size_t light_number) {
  const double fresh = noise_.gaussian();
  if (light_number >= last_noise_.size()) {
    last_noise_.push_back(fresh);  // lights are taken in order: this one is new
    return fresh;
  }
  const double correlation = config_.correlation;
  double& noise = last_noise_[light_number];
  noise = correlation * noise + std::sqrt(1.0 - correlation * correlation) * fresh;
  return noise;
}

/// Of the light as the tilted sensor sees it.
double BearingSensor::tiltedAzimuth(const Light& light, const Pose2& world_from_sensor) const {
  if (config_.roll_rad == 0.0 && config_.pitch_rad == 0.0) {
    return azimuthOf(light, world_from_sensor);
  }
  const Eigen::Vector3d in_sensor = tilted(light, world_from_sensor);
  return std::atan2(in_sensor.y(), in_sensor.x());
}

Eigen::Vector3d BearingSensor::tilted(const Light& light, const Pose2& world_from_sensor) const {
  const auto level_from_tilted = Eigen::AngleAxisd(config_.pitch_rad, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(config_.roll_rad, Eigen::Vector3d::UnitX());
  return level_from_tilted.inverse() * positionInSensor(light, world_from_sensor);
}

/// As the mirror bends it.
double BearingSensor::bent(double azimuth_rad) const {
  return azimuth_rad + config_.harmonic_cos_rad * std::cos(azimuth_rad) +
         config_.harmonic_sin_rad * std::sin(azimuth_rad);
}

BearingSet BearingSensor::measure(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                                  Stamp stamp) {
  BearingSet bearings{stamp, {}};
  for (std::size_t i = 0; i < lights.size(); ++i) {
    // Every draw is made whatever it decides, so that one fault's rate leaves the others alone.
    const double noise_rad = config_.stddev_rad * nextNoise(i);
    const bool is_missed = faults_.happens(config_.miss_probability);
    const bool is_outlier = faults_.happens(config_.outlier_probability);
    const double anywhere_rad = 2.0 * kPi * (faults_.uniform() - 0.5);
    const double elevation_noise_rad = config_.elevation_stddev_rad * elevation_noise_.gaussian();
    const double any_elevation_rad = kPi * (elevation_noise_.uniform() - 0.5);
    if (is_missed) continue;
    Bearing bearing;
    bearing.azimuth_rad =
        is_outlier ? anywhere_rad
                   : wrapAngle(bent(tiltedAzimuth(lights[i], world_from_sensor)) + noise_rad);
    bearing.azimuth_variance_rad2 =
        std::max(config_.stddev_rad * config_.stddev_rad, kLeastVariance);
    if (config_.elevation_stddev_rad > 0.0) {
      const Eigen::Vector3d in_sensor = tilted(lights[i], world_from_sensor);
      const double elevation_rad = std::atan2(in_sensor.z(), in_sensor.head<2>().norm());
      bearing.elevation_rad = is_outlier ? any_elevation_rad : elevation_rad + elevation_noise_rad;
      bearing.elevation_variance_rad2 = std::pow(config_.elevation_stddev_rad, 2);
    }
    if (config_.identifies_lights) bearing.light_id = static_cast<std::int32_t>(i);
    bearings.candidates.push_back(bearing);
  }
  return bearings;
}

BearingSet exactBearings(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                         Stamp stamp) {
  BearingSet bearings{stamp, {}};
  for (std::size_t i = 0; i < lights.size(); ++i) {
    Bearing bearing;
    bearing.azimuth_rad = azimuthOf(lights[i], world_from_sensor);
    bearing.azimuth_variance_rad2 = BearingSensor::kLeastVariance;
    bearing.light_id = static_cast<std::int32_t>(i);
    bearings.candidates.push_back(bearing);
  }
  return bearings;
}

}  // namespace bearing_calibration::core
