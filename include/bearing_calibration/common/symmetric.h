#pragma once

#include <Eigen/Core>

// Decompositions of symmetric matrices of any size. They are Eigen's, and compiled once: where its
// templates are used, each takes the compiler seconds.

namespace bearing_calibration::core {

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< in increasing order
  Eigen::MatrixXd vectors;  ///< one in each column
};
SymmetricEigen eigenOf(const Eigen::MatrixXd& symmetric);

/// positive^-1 right; `positive` is positive definite.
Eigen::MatrixXd solved(const Eigen::MatrixXd& positive, const Eigen::MatrixXd& right);
Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& positive);

/// Square of the Mahalanobis distance: off^T covariance^-1 off.
double chiSquareOf(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance);

}  // namespace bearing_calibration::core
