#pragma once

#include <Eigen/Core>

#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

/// A converged result with round numbers: its standard deviations are 1 mm, 2 mm and 3 mrad.
inline SavedCalibration someCalibration() {
  SavedCalibration saved;
  CalibrationResult& result = saved.result;
  result.state = CalibrationState::kConverged;
  result.base_from_sensor = {{0.2, -0.1, 0.7}, Eigen::Vector3d(1e-6, 4e-6, 9e-6).asDiagonal()};
  result.paper_state.emplace().covariance.setIdentity();
  result.cartesian_state.emplace().covariance.setIdentity();
  saved.base_frame = "base_link";
  saved.sensor_frame = "camera";
  saved.unestimated = {0.35, 0.01, 0.02, 0.02, -0.03, 0.03};
  saved.provenance.written_at = "2026-01-01T00:00:00Z";
  saved.provenance.drive = {0.25, 0.05, 0.05, 2048.0, 16, 1.5};
  return saved;
}

}  // namespace bearing_calibration::core
