#pragma once

#include <cstdint>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/input/bearing_input.h"
#include "bearing_calibration/judge/convergence_config.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/track/mount_tracker.h"

namespace bearing_calibration::core {

/// What is known before the first measurement. Parameter group `initialisation`.
struct InitialisationConfig {
  enum class Kind : std::uint8_t {
    kNothing,  ///< the initialiser finds mount and light by itself
    kGuess,    ///< a rough guess of everything below
  };
  Kind kind = Kind::kNothing;
  double light_distance_m = 0.0;  ///< from the sensor to the light at the first observation
  double light_distance_stddev_m = 0.0;
  double x_m = 0.0;  ///< sensor position in the base frame
  double y_m = 0.0;
  double position_stddev_m = 0.0;  ///< of x and of y
  double yaw_rad = 0.0;            ///< sensor yaw in the base frame
  double yaw_stddev_rad = 0.0;

  MountEstimate mount() const;
  void declare(Parameters& params);
};

/// Everything that the calibrator needs to know; a plain struct without defaults worth running:
/// they stand in config/calibration.yaml.
struct CalibratorConfig {
  DriveGeometry drive;
  WheelNoise wheel_noise;
  WheelTimes wheel_times;
  BearingInputConfig bearings;
  InitialisationConfig initialisation;
  /// Not among the parameters, for its values hold for every robot, but for batch.errors: those of
  /// this one. Parameter group `errors`.
  InitializerConfig initializer;
  FilterConfig filter;
  ConvergenceConfig converged;
  /// More than one: each is calibrated with, and all of them together. Parameter group `session`,
  /// as the next one.
  int max_lights = 1;
  /// When the mount has moved after it was calibrated, calibrates anew by itself, from nothing;
  /// otherwise the calibration stays INCONSISTENT.
  bool restart_on_mount_change = false;
  /// The record is fitted anew when it has grown by this share of itself, and a second at least.
  /// Not among the parameters.
  double refit_growth = 0.02;

  void declare(Parameters& params);
};

}  // namespace bearing_calibration::core
