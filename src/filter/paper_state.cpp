#include "bearing_calibration/filter/paper_state.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSmallestDistance_m = 1e-9;  // a direction's derivative is 1 / distance
constexpr double kDirectionUnknownVariance_rad2 = kPi * kPi / 3.0;  // uniform on a circle
constexpr double kDeterminedSigmas = 3.0;

}  // namespace

PaperEstimate paperFromCartesian(const CartesianEstimate& cartesian) {
  const Eigen::Vector2d light = cartesian.lightInBase();
  const Eigen::Vector2d sensor = cartesian.sensorInBase();
  const double distance = std::max(light.norm(), kSmallestDistance_m);
  const double rho = sensor.norm();
  const double phi = std::atan2(sensor.y(), sensor.x());
  const Eigen::Vector2d along(std::cos(phi), std::sin(phi));

  Eigen::Matrix<double, 1, 5> J_phi = Eigen::Matrix<double, 1, 5>::Zero();
  J_phi.segment<2>(CartesianIndex::kSensorX) =
      perpendicular(along).transpose() / std::max(rho, kSmallestDistance_m);
  const double phi_variance = (J_phi * cartesian.covariance * J_phi.transpose()).value();
  if (phi_variance > kDirectionUnknownVariance_rad2) {
    J_phi *= std::sqrt(kDirectionUnknownVariance_rad2 / phi_variance);
  }

  Matrix5 J_paper_cartesian = Matrix5::Zero();
  J_paper_cartesian.row(PaperIndex::kDistance).head<2>() = light.transpose() / distance;
  J_paper_cartesian.row(PaperIndex::kTheta).head<2>() =
      -perpendicular(light).transpose() / (distance * distance);
  J_paper_cartesian.row(PaperIndex::kPhi) = J_phi;
  J_paper_cartesian.row(PaperIndex::kRho).segment<2>(CartesianIndex::kSensorX) = along.transpose();
  J_paper_cartesian.row(PaperIndex::kPsi) = -J_phi;
  J_paper_cartesian(PaperIndex::kPsi, CartesianIndex::kSensorYaw) = 1.0;

  PaperEstimate paper;
  paper.mean << distance, wrapAngle(-std::atan2(-light.y(), -light.x())), phi, rho,
      wrapAngle(cartesian.sensorYaw() - phi);
  paper.covariance = J_paper_cartesian * cartesian.covariance * J_paper_cartesian.transpose();
  paper.phi_psi_determined =
      isRhoDetermined(rho, paper.covariance(PaperIndex::kRho, PaperIndex::kRho));
  return paper;
}

CartesianEstimate cartesianFromPaper(const PaperEstimate& paper) {
  const Vector5& X = paper.mean;
  const Eigen::Vector2d to_light =  // the light lies against the direction to the base
      -rotation2(-X(PaperIndex::kTheta)) * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d to_sensor = rotation2(X(PaperIndex::kPhi)) * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d light = X(PaperIndex::kDistance) * to_light;
  const Eigen::Vector2d sensor = X(PaperIndex::kRho) * to_sensor;

  Matrix5 J_cartesian_paper = Matrix5::Zero();
  J_cartesian_paper.col(PaperIndex::kDistance).head<2>() = to_light;
  J_cartesian_paper.col(PaperIndex::kTheta).head<2>() = -perpendicular(light);
  J_cartesian_paper.col(PaperIndex::kPhi).segment<2>(CartesianIndex::kSensorX) =
      perpendicular(sensor);
  J_cartesian_paper.col(PaperIndex::kRho).segment<2>(CartesianIndex::kSensorX) = to_sensor;
  J_cartesian_paper(CartesianIndex::kSensorYaw, PaperIndex::kPhi) = 1.0;
  J_cartesian_paper(CartesianIndex::kSensorYaw, PaperIndex::kPsi) = 1.0;

  CartesianEstimate cartesian;
  cartesian.mean << light, sensor, wrapAngle(X(PaperIndex::kPhi) + X(PaperIndex::kPsi));
  cartesian.covariance = J_cartesian_paper * paper.covariance * J_cartesian_paper.transpose();
  return cartesian;
}

MountEstimate mountFromCartesian(const CartesianEstimate& cartesian) {
  return {cartesian.mean.tail<3>(), cartesian.covariance.bottomRightCorner<3, 3>()};
}

bool isRhoDetermined(double rho_m, double rho_variance_m2) {
  return rho_m * rho_m > kDeterminedSigmas * kDeterminedSigmas * rho_variance_m2;
}

}  // namespace bearing_calibration::core
