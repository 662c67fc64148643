#include "bench/reference/dynamic_ekf.h"

#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core::reference {
namespace {

constexpr Eigen::Index kModelStates = 5;

}  // namespace

DynamicEkf::DynamicEkf(const CartesianEstimate& start, Eigen::Index states)
    : mean_(Eigen::VectorXd::Zero(states)), covariance_(Eigen::MatrixXd::Identity(states, states)) {
  if (states < kModelStates) throw std::invalid_argument("the filter needs at least 5 states");
  mean_.head(kModelStates) = start.mean;
  covariance_.topLeftCorner(kModelStates, kModelStates) = start.covariance;
}

void DynamicEkf::predict(const OdometryIncrement& motion) {
  const Eigen::Index n = mean_.size();
  const Eigen::Matrix2d R = rotation2(-motion.start_from_end.yaw_rad);
  const Eigen::Vector2d light = R * (mean_.head<2>() - motion.start_from_end.position_m);
  Eigen::MatrixXd F = Eigen::MatrixXd::Identity(n, n);
  F.topLeftCorner<2, 2>() = R;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, 3);
  G.topLeftCorner<2, 2>() = -R;
  G.block<2, 1>(0, 2) = -perpendicular(light);
  mean_.head<2>() = light;
  covariance_ = F * covariance_ * F.transpose() + G * motion.covariance * G.transpose();
}

void DynamicEkf::update(double azimuth_rad, double azimuth_variance_rad2) {
  const Eigen::Index n = mean_.size();
  const Eigen::Vector2d ray = mean_.head<2>() - mean_.segment<2>(CartesianIndex::kSensorX);
  const double expected = std::atan2(ray.y(), ray.x()) - mean_(CartesianIndex::kSensorYaw);
  const Eigen::RowVector2d J = perpendicular(ray).transpose() / ray.squaredNorm();
  Eigen::RowVectorXd H = Eigen::RowVectorXd::Zero(n);
  H.segment<2>(CartesianIndex::kLightX) = J;
  H.segment<2>(CartesianIndex::kSensorX) = -J;
  H(CartesianIndex::kSensorYaw) = -1.0;
  const Eigen::VectorXd PHt = covariance_ * H.transpose();
  const double S = H * PHt + azimuth_variance_rad2;
  const Eigen::VectorXd K = PHt / S;
  mean_ += K * wrapAngle(azimuth_rad - expected);
  const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(n, n) - K * H;
  covariance_ = I_KH * covariance_ * I_KH.transpose() + K * azimuth_variance_rad2 * K.transpose();
}

}  // namespace bearing_calibration::core::reference
