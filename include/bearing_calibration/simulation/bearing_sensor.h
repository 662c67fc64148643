#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/random_stream.h"

namespace bearing_calibration::core {

/// A sensor of azimuths with Gaussian noise: what the paper simulates, and a stand-in for camera
/// and detector where images would take too long.
struct BearingSensorConfig {
  double stddev_rad = 0.0;            ///< of one azimuth; also what the sensor says of itself
  double elevation_stddev_rad = 0.0;  ///< the same of one elevation; 0: it measures none
  double correlation = 0.0;           ///< of one azimuth's noise with that of the next, in [0, 1)
  double outlier_probability = 0.0;   ///< a bearing is replaced by a uniform one, same variance
  double miss_probability = 0.0;      ///< a light is not seen
  bool identifies_lights = false;     ///< candidates carry the light's number, else none
  /// Its orientation in a level sensor of the same yaw: Ry(pitch) Rx(roll).
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double harmonic_cos_rad = 0.0;  ///< of the azimuth's error: cos, sin of the azimuth times these
  double harmonic_sin_rad = 0.0;

  void declare(Parameters& params);
};

class BearingSensor {
 public:
  /// Variance of a sensor without noise: too small to matter, but not zero.
  static constexpr double kLeastVariance = 1e-12;

  /// @throws std::invalid_argument with what errorsOf() says.
  BearingSensor(const BearingSensorConfig& config, std::uint64_t seed);

  /// One candidate for each light that is seen, with all the noise.
  BearingSet measure(const std::vector<Light>& lights, const Pose2& world_from_sensor, Stamp stamp);

 private:
  double nextNoise(std::size_t light_number);
  double tiltedAzimuth(const Light& light, const Pose2& world_from_sensor) const;
  Eigen::Vector3d tilted(const Light& light, const Pose2& world_from_sensor) const;
  double bent(double azimuth_rad) const;

  BearingSensorConfig config_;
  RandomStream noise_;
  RandomStream faults_;
  RandomStream elevation_noise_;
  std::vector<double> last_noise_;  ///< of each light, in standard deviations
};

/// One exact candidate for each light, numbered, with the least variance.
BearingSet exactBearings(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                         Stamp stamp);

}  // namespace bearing_calibration::core
