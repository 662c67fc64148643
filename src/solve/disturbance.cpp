#include "bearing_calibration/solve/disturbance.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace bearing_calibration::core {
namespace {

/// What a jump takes off the cost, along the directions in which it is told.
template <int D>
double gainOf(const Eigen::Matrix<double, D, 1>& pull,
              const Eigen::Matrix<double, D, D>& information, double least_information) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, D, D>> solver;
  solver.computeDirect(information);
  double gain = 0.0;
  for (int i = 0; i < D; ++i) {
    if (solver.eigenvalues()(i) < least_information) continue;
    gain += std::pow(solver.eigenvectors().col(i).dot(pull), 2) / solver.eigenvalues()(i);
  }
  return gain;
}

/// W with W^T squares W = I, where they are positive.
Eigen::Matrix3d inverseRoot(const Eigen::Matrix3d& squares) {
  constexpr double kRounding = 1e-12;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(squares);
  const Eigen::Array3d values = solver.eigenvalues();
  const Eigen::Array3d scale = (values > kRounding * values.maxCoeff()).select(values.rsqrt(), 0.0);
  return solver.eigenvectors() * scale.matrix().asDiagonal();
}

}  // namespace

Disturbance::Disturbance(const StateLayout& layout)
    : layout_(layout),
      r_(StateVector::Zero(layout.size())),
      N_(StateMatrix::Zero(layout.size(), layout.size())) {}

void Disturbance::add(const ScalarUpdate& number, double pull_variance, const StateVector& future) {
  const auto& [residual, variance] = number.innovation;
  const double surprise = residual / variance - number.gain.dot(r_);
  r_ += number.H * surprise;
  // (I - KH)' N (I - KH) + H'H/S, written as updates of rank 1 and 2
  const double scale = future.dot(number.gain) + pull_variance;
  const StateVector half = 0.5 * scale * number.H - future;
  N_.noalias() += number.H * half.transpose();
  N_.noalias() += half * number.H.transpose();
}

void Disturbance::passMotion(const LinearMotion& motion) {
  const int size = 2 * layout_.lights;
  const int errors = layout_.errors;
  if (errors > 0) {
    const auto J = motion.J_lights_errors.transpose();
    r_.segment(kMountSize, errors) += J.lazyProduct(r_.tail(size));
    N_.middleRows(kMountSize, errors) += J.lazyProduct(N_.bottomRows(size));
    N_.middleCols(kMountSize, errors) += N_.rightCols(size).lazyProduct(motion.J_lights_errors);
  }
  const Eigen::Matrix2d& R = motion.R_end_start;
  for (int light = 0; light < layout_.lights; ++light) {
    const int at = layout_.lightAt(light);
    r_.segment<2>(at) = (R.transpose() * r_.segment<2>(at)).eval();
    N_.middleRows<2>(at) = (R.transpose() * N_.middleRows<2>(at)).eval();
  }
  for (int light = 0; light < layout_.lights; ++light) {
    const int at = layout_.lightAt(light);
    N_.middleCols<2>(at) = (N_.middleCols<2>(at) * R).eval();
  }
}

double Disturbance::slipGain(const LinearMotion& motion, double range_m2) const {
  constexpr double kTellable = 0.2;  // standard deviation of the jump, over the range
  const double least_information = 1.0 / (kTellable * kTellable * range_m2);
  const int size = 2 * layout_.lights;
  if (layout_.lights == 1)
    return gainOf<2>(r_.tail<2>(), N_.bottomRightCorner<2, 2>(), least_information);
  // One light can go anywhere, several only as the base takes them: along the columns of J.
  const auto& J = motion.J_lights_error;
  const Eigen::Matrix3d orthonormal = inverseRoot(J.transpose().lazyProduct(J));
  const Eigen::Vector3d pull = J.transpose().lazyProduct(r_.tail(size));
  const auto N_J = N_.bottomRightCorner(size, size).lazyProduct(J).eval();
  return gainOf<3>(orthonormal.transpose() * pull,
                   orthonormal.transpose() * J.transpose().lazyProduct(N_J) * orthonormal,
                   least_information);
}

}  // namespace bearing_calibration::core
