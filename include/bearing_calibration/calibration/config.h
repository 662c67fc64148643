#pragma once

#include <cstdint>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/input/bearing_input.h"
#include "bearing_calibration/judge/convergence_judge.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/track/mount_tracker.h"

namespace bearing_calibration::core {

/// Everything that the calibrator needs to know; a plain struct without defaults worth running:
/// they stand in config/calibration.yaml, and for programs without files in shippedCalibration().
struct CalibratorConfig {
  DriveGeometry drive;
  WheelNoise wheel_noise;
  WheelTimes wheel_times;
  BearingInputConfig bearings;
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

/// Where fits, which take up to a second, are done.
enum class FitsRun : std::uint8_t {
  kAtOnce,  ///< within the input that makes them due: the same inputs, the same results
  kBeside,  ///< on another thread: an input takes no longer than the filter does
};

}  // namespace bearing_calibration::core
