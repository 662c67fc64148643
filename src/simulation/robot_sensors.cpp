#include "bearing_calibration/simulation/robot_sensors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace bearing_calibration::core {

std::int64_t wrapCounter(std::int64_t count, int bits, bool is_signed) {
  const std::int64_t wrapped = wrappedTickDifference(0, count, bits);
  const bool is_shown_as_it_is = is_signed || wrapped >= 0 || bits == 64;
  return is_shown_as_it_is ? wrapped : wrapped + (std::int64_t{1} << bits);
}

void EncoderConfig::declare(Parameters& params) {
  using plausible::kLargestRatio;
  drive.declare(params);
  params.read("wheels/signed_counters", signed_counters);
  for (auto [name, ticks] : {std::pair("wheels/left_start", &left_start_ticks),
                             std::pair("wheels/right_start", &right_start_ticks)}) {
    int start = 0;
    if (params.read(name, start)) *ticks = start;
  }
  noise.declareLevels(params);
  params.number("faults/left_radius_factor", left_radius_factor, 1.0 / kLargestRatio,
                kLargestRatio);
  params.number("faults/right_radius_factor", right_radius_factor, 1.0 / kLargestRatio,
                kLargestRatio);
}

WheelEncoders::WheelEncoders(const EncoderConfig& config, std::uint64_t seed)
    : config_(validated(config)), random_(seed, RandomStream::Purpose::kEncoders) {
  left_ = {0.0, config.drive.leftMetersPerTick() * config.left_radius_factor,
           config.left_start_ticks};
  right_ = {0.0, config.drive.rightMetersPerTick() * config.right_radius_factor,
            config.right_start_ticks};
}

void WheelEncoders::roll(const WheelDisplacement& turned) {
  const WheelNoise& noise = config_.noise;
  const auto own_error = [&](double displacement_m) {
    return std::sqrt(noise.independent_k_m * std::abs(displacement_m)) * random_.gaussian();
  };
  left_.reported_m += turned.left_m + own_error(turned.left_m);
  right_.reported_m += turned.right_m + own_error(turned.right_m);
  if (noise.common_k_m > 0.0) {
    const double distance_m = 0.5 * std::abs(turned.left_m + turned.right_m);
    const double shared_error_m = std::sqrt(noise.common_k_m * distance_m) * random_.gaussian();
    left_.reported_m += shared_error_m;
    right_.reported_m += shared_error_m;
  }
}

std::int64_t WheelEncoders::count(const Wheel& wheel) const {
  const double ticks = std::floor(wheel.reported_m / wheel.meters_per_tick);
  return wrapCounter(wheel.start_ticks + static_cast<std::int64_t>(ticks),
                     config_.drive.counter_bits, config_.signed_counters);
}

WheelCounts WheelEncoders::read(Stamp stamp) const { return {stamp, count(left_), count(right_)}; }

void WheelEncoders::resetCounters() {
  for (Wheel* wheel : {&left_, &right_}) {
    wheel->reported_m = 0.0;
    wheel->start_ticks = 0;
  }
}

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
  const double r = config_.correlation;
  double& noise = last_noise_[light_number];
  return noise = r * noise + std::sqrt(1.0 - r * r) * fresh;
}

Bearing BearingSensor::seen(const Light& light, const Pose2& world_from_sensor) const {
  constexpr double kLeastVariance_rad2 = 1e-12;  // without noise: too small to matter, but not zero
  const auto level_from_tilted = Eigen::AngleAxisd(config_.pitch_rad, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(config_.roll_rad, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d in_sensor =
      level_from_tilted.inverse() * inSensor(light, world_from_sensor).place_m();
  const bool is_level = config_.roll_rad == 0.0 && config_.pitch_rad == 0.0;
  const double azimuth_rad =
      is_level ? azimuthOf(light, world_from_sensor) : std::atan2(in_sensor.y(), in_sensor.x());
  Bearing bearing;
  bearing.azimuth_rad = azimuth_rad + config_.harmonic_cos_rad * std::cos(azimuth_rad) +
                        config_.harmonic_sin_rad * std::sin(azimuth_rad);
  bearing.azimuth_variance_rad2 =
      std::max(config_.stddev_rad * config_.stddev_rad, kLeastVariance_rad2);
  if (config_.elevation_stddev_rad > 0.0) {
    bearing.elevation_rad = std::atan2(in_sensor.z(), in_sensor.head<2>().norm());
    bearing.elevation_variance_rad2 = std::pow(config_.elevation_stddev_rad, 2);
  }
  return bearing;
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
    Bearing bearing = seen(lights[i], world_from_sensor);
    bearing.azimuth_rad = is_outlier ? anywhere_rad : wrapAngle(bearing.azimuth_rad + noise_rad);
    if (config_.elevation_stddev_rad > 0.0) {
      bearing.elevation_rad =
          is_outlier ? any_elevation_rad : bearing.elevation_rad + elevation_noise_rad;
    }
    if (config_.identifies_lights) bearing.light_id = static_cast<std::int32_t>(i);
    bearings.candidates.push_back(bearing);
  }
  return bearings;
}

BearingSet exactBearings(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                         Stamp stamp) {
  BearingSensorConfig exact;
  exact.identifies_lights = true;
  return BearingSensor(exact, 0).measure(lights, world_from_sensor, stamp);
}

}  // namespace bearing_calibration::core
