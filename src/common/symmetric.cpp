#include "bearing_calibration/common/symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace bearing_calibration::core {

SymmetricEigen eigenOf(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd solved(const Eigen::MatrixXd& positive, const Eigen::MatrixXd& right) {
  return positive.ldlt().solve(right);
}

Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& positive) {
  return solved(positive, Eigen::MatrixXd::Identity(positive.rows(), positive.cols()));
}

double chiSquareOf(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance) {
  return off.dot(solved(covariance, off).col(0));
}

}  // namespace bearing_calibration::core
