#pragma once

#include <Eigen/Core>

namespace bearing_calibration::core {

/// A measurement of one number against its prediction.
struct Innovation {
  double residual;  ///< measured minus predicted, wrapped where it is an angle
  double variance;  ///< S = H P H^T + R

  double nis() const { return residual * residual / variance; }
};

/// Mean and covariance of N numbers.
template <int N>
struct Gaussian {
  Eigen::Matrix<double, N, 1> mean;
  Eigen::Matrix<double, N, N> covariance;
};

/// The EKF's update by one number: the Joseph form, which keeps the covariance symmetric and
/// positive whatever the gain's rounding. Equation 8 of doc/model.md; of many states its products
/// are multiplied out, which makes the cost grow with their square instead of their cube.
/// @param H  Jacobian of the measurement by the state
/// @param residual  innovation
/// @param R  variance of the measurement, > 0
template <int N>
Gaussian<N> updateScalar(const Gaussian<N>& prior, const Eigen::Matrix<double, 1, N>& H,
                         double residual, double R) {
  const Eigen::Matrix<double, N, 1> PHt = prior.covariance * H.transpose();
  const double S = (H * PHt).value() + R;
  const Eigen::Matrix<double, N, 1> K = PHt / S;
  Eigen::Matrix<double, N, N> P;
  if constexpr (N <= 5) {
    const Eigen::Matrix<double, N, N> I_KH = Eigen::Matrix<double, N, N>::Identity() - K * H;
    P = I_KH * prior.covariance * I_KH.transpose() + K * R * K.transpose();
  } else {
    const Eigen::Matrix<double, N, N> half = K * (PHt - 0.5 * S * K).transpose();
    P = prior.covariance - (half + half.transpose());
  }
  return {prior.mean + K * residual, 0.5 * (P + P.transpose())};
}

}  // namespace bearing_calibration::core
