#pragma once

#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/noise_levels.h"

namespace bearing_calibration::core {

/// What one light by itself said of the mount the last time that a fit of its record settled.
struct LandmarkSolution {
  std::vector<Stamp> stamps;  ///< of the record's observations
  BatchEstimate fit;          ///< over them
  RobotEstimate average;  ///< with its rivals (see averageOverSlips) and all levels of noise, at
                          ///< the last observation
  /// No part of the record says another mount than the rest, and both halves tell it.
  bool tells_one_mount = false;
  double motion_m = 0.0;  ///< of the record, its turns included
  NoiseLevels noise;      ///< against the stated one
};

}  // namespace bearing_calibration::core
