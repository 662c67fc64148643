#pragma once

#include <Eigen/Core>

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/odometry/odometry_increment.h"

namespace bearing_calibration::core::reference {

/// The Cartesian filter as it is usually written: matrices of dynamic size, every product dense.
/// The state is that of CartesianIndex, followed by any number of constants that neither motion nor
/// bearing speaks of, as the further states of a general-purpose filter.
class DynamicEkf {
 public:
  /// @param states  length of the state, at least 5
  DynamicEkf(const CartesianEstimate& start, Eigen::Index states);

  void predict(const OdometryIncrement& motion);
  void update(double azimuth_rad, double azimuth_variance_rad2);

  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
};

}  // namespace bearing_calibration::core::reference
