#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/initializer.h"
#include "bearing_calibration/odometry/drive_geometry.h"

namespace bearing_calibration {

/// The bounds of the bearings' input and their noise. Parameter group `bearings`.
struct BearingInputConfig {
  /// Seconds to take off a bearing's stamp to get the moment on the encoders' clock at which the
  /// light was seen: positive when the camera's stamps are late.
  double latency_s = 0.0;
  /// What the sensor's own variance does not contain (mount, mirror, light): added to each [rad].
  double extra_stddev_rad = 0.0;
  double min_stddev_rad = 0.0;  ///< a stated one below it, of azimuth or elevation, is raised to it
  double max_stddev_rad = 0.0;  ///< a candidate with a larger one is refused
  double max_future_s = 0.0;    ///< a stamp later than its receipt by more is refused
  /// Bearings wait this long after their stamp for earlier ones of other sensors [s].
  double reorder_window_s = 0.0;
  int max_waiting = 0;       ///< messages that may wait for ticks before the oldest is dropped
  double min_quality = 0.0;  ///< candidates of lower quality are not considered

  std::vector<std::string> validate() const;
};

/// What is known before the first measurement. Parameter group `start`.
struct StartConfig {
  enum class Kind : std::uint8_t {
    kNothing,  ///< the initialiser finds mount and light by itself
    kGuess,    ///< a rough guess of everything below
  };
  Kind kind = Kind::kNothing;
  double light_distance_m = 0.0;  ///< from the sensor to the light at the first sight
  double light_distance_stddev_m = 0.0;
  double x_m = 0.0;  ///< sensor position in the base frame
  double y_m = 0.0;
  double position_stddev_m = 0.0;  ///< of x and of y
  double yaw_rad = 0.0;            ///< sensor yaw in the base frame
  double yaw_stddev_rad = 0.0;

  std::vector<std::string> validate() const;
};

/// Parameter group `filter`.
struct FilterConfig {
  enum class Chart : std::uint8_t {
    kCartesian,  ///< light and sensor in the base frame
    kPaper,      ///< X = [D, theta, phi, rho, psi]
  };
  Chart chart = Chart::kCartesian;
  double gate_probability = 0.0;  ///< a true bearing passes the chi-square gate with this one
  /// So many gated bearings in a row, and the light's block is widened by the two amounts below.
  int recovery_after = 0;
  double recovery_bearing_stddev_rad = 0.0;  ///< across the line of sight, as an angle
  double recovery_distance_stddev_m = 0.0;   ///< along and across the line of sight

  std::vector<std::string> validate() const;
};

/// When the calibration may call itself converged. Parameter group `converged`.
struct ConvergenceConfig {
  double position_stddev_m = 0.0;  ///< x and y each
  double yaw_stddev_rad = 0.0;

  std::vector<std::string> validate() const;
};

/// What is done when the mount has moved after it was calibrated. Parameter group `knocked`.
struct KnockConfig {
  /// Calibrates anew by itself, from nothing; otherwise the calibration stays INCONSISTENT.
  bool start_anew = false;
};

/// How many lights share the mount. Parameter group `lights`.
struct LightsConfig {
  int most = 1;  ///< more than one: each is calibrated with, and all of them together

  std::vector<std::string> validate() const;
};

/// Everything that the calibrator needs to know; a plain struct without defaults worth running:
/// they stand in config/calibration.yaml.
struct CalibratorConfig {
  DriveGeometry drive;
  WheelNoise wheel_noise;
  double max_wheels_apart_s = 0.0;  ///< see WheelPairing; only for wheels that come one by one
  double tick_history_s = 0.0;      ///< travel is remembered so long for bearings that arrive late
  BearingInputConfig bearings;
  StartConfig start;
  /// Not among the parameters, for its values hold for every robot, but for batch.errors: those of
  /// this one. Parameter group `errors`.
  InitializerConfig initializer;
  FilterConfig filter;
  ConvergenceConfig converged;
  KnockConfig knocked;
  LightsConfig lights;
  /// The record is fitted anew when it has grown by this share of itself, and a second at least.
  /// Not among the parameters.
  double refit_growth = 0.005;

  /// One sentence for each value that cannot be; empty when all is well.
  std::vector<std::string> validate() const;
};

}  // namespace bearing_calibration
