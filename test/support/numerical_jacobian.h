#pragma once

#include <Eigen/Core>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core::testing {

/// Central differences of `function` at `x`, independent of every Jacobian in the package. Outputs
/// listed in `angle_rows` are differenced on the circle.
template <int Rows, int Cols, class Function>
Eigen::Matrix<double, Rows, Cols> numericalJacobian(const Function& function,
                                                    const Eigen::Matrix<double, Cols, 1>& x,
                                                    std::initializer_list<int> angle_rows = {}) {
  constexpr double kStep = 1e-6;  // error of order step^2, rounding of order 1e-16 / step
  Eigen::Matrix<double, Rows, Cols> jacobian;
  for (int i = 0; i < Cols; ++i) {
    Eigen::Matrix<double, Cols, 1> forward = x;
    Eigen::Matrix<double, Cols, 1> backward = x;
    forward(i) += kStep;
    backward(i) -= kStep;
    Eigen::Matrix<double, Rows, 1> difference = function(forward) - function(backward);
    for (int row : angle_rows) difference(row) = wrapAngle(difference(row));
    jacobian.col(i) = difference / (2.0 * kStep);
  }
  return jacobian;
}

/// The largest difference of two matrices' entries, in units of max(1, |entry|).
template <class A, class B>
double largestDifference(const A& a, const B& b) {
  return ((a - b).array().abs() / a.array().abs().max(1.0)).maxCoeff();
}

}  // namespace bearing_calibration::core::testing
