#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/random_numbers.h"

namespace bearing_calibration::core {

/// The counter that a driver with `bits` (8, 16, 32 or 64) sends for a count of any size:
/// in [-2^(bits-1), 2^(bits-1)) when signed, in [0, 2^bits) otherwise (64 bits are always signed).
std::int64_t wrapCounter(std::int64_t count, int bits, bool is_signed);

struct EncoderConfig {
  DriveGeometry drive;  ///< as the robot's owner believes it
  WheelNoise noise;
  double left_radius_factor = 1.0;  ///< true wheel radius over the believed one
  double right_radius_factor = 1.0;
  bool signed_counters = true;
  std::int64_t left_start_ticks = 0;  ///< counts before the first motion
  std::int64_t right_start_ticks = 0;

  void declare(Parameters& params);
};

/// Two encoders that count what the wheels roll, with the errors of Chong and Kleeman (paper,
/// eq. 22): the displacement reported is the true one plus N(0, K |displacement|).
class WheelEncoders {
 public:
  /// @throws std::invalid_argument with what errorsOf() says.
  WheelEncoders(const EncoderConfig& config, std::uint64_t seed);

  /// `turned`: what each wheel's rim has turned by (the way over ground unless it slips).
  void roll(const WheelDisplacement& turned);
  /// Counts of whole ticks so far, wrapped.
  WheelCounts read(Stamp stamp) const;
  /// The driver restarts and counts from zero again.
  void resetCounters();

 private:
  struct Wheel {
    double reported_m = 0.0;  ///< noisy travel since the last reset of the counter
    double meters_per_tick = 0.0;
    std::int64_t start_ticks = 0;
  };
  std::int64_t count(const Wheel& wheel) const;

  EncoderConfig config_;
  RandomStream random_;
  Wheel left_;
  Wheel right_;
};

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
  /// @throws std::invalid_argument with what errorsOf() says.
  BearingSensor(const BearingSensorConfig& config, std::uint64_t seed);

  /// One candidate for each light that is seen, with all the noise.
  BearingSet measure(const std::vector<Light>& lights, const Pose2& world_from_sensor, Stamp stamp);

 private:
  double nextNoise(std::size_t light_number);
  /// Without noise.
  Bearing seen(const Light& light, const Pose2& world_from_sensor) const;

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
