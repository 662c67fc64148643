#pragma once

#include <cstdint>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/simulation/random_stream.h"

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

}  // namespace bearing_calibration::core
