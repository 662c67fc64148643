#pragma once

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core::testing {

/// Squared error of the mount over its covariance: chi-square with 3 degrees of freedom when
/// honest.
inline double mountChiSquare(const CartesianEstimate& estimate, const Vector5& truth) {
  Eigen::Vector3d error = (estimate.mean - truth).tail<3>();
  error(2) = wrapAngle(error(2));
  const Eigen::Matrix3d covariance = estimate.covariance.bottomRightCorner<3, 3>();
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace bearing_calibration::core::testing
