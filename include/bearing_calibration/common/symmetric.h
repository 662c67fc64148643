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

/// Rounding makes the two halves of a covariance differ a little, and what is made of it makes the
/// difference grow: both become their mean.
template <class Matrix>
void symmetrise(Matrix* covariance) {
  Matrix& P = *covariance;
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
  }
}

}  // namespace bearing_calibration::core
