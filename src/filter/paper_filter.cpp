#include "bearing_calibration/filter/paper_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSmallestDistance_m = 1e-9;  // a direction's derivative is 1 / distance
constexpr double kDirectionUnknownVariance_rad2 = kPi * kPi / 3.0;  // uniform on a circle
constexpr double kDeterminedSigmas = 3.0;

/// Whether rho is so clearly above zero that phi and psi mean something.
bool isRhoDetermined(double rho_m, double rho_variance_m2) {
  return rho_m * rho_m > kDeterminedSigmas * kDeterminedSigmas * rho_variance_m2;
}

/// A matrix R of which R R^T is the covariance, without what rounding has made negative of it.
Matrix5 rootOf(const Matrix5& covariance) {
  const Eigen::LDLT<Matrix5> factors(covariance);
  Matrix5 root = factors.matrixL();
  root *= factors.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  return factors.transpositionsP().transpose() * root;
}

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
  // A sum of squares: rounding, which 1 / rho makes large, leaves no variance negative.
  const Matrix5 J_root = J_paper_cartesian * rootOf(cartesian.covariance);
  paper.covariance = J_root * J_root.transpose();
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

PaperPropagation propagatePaper(const Vector5& state, const OdometryIncrement& motion) {
  // In the frame at the light whose x axis points to the base: the base stands at (D, 0) with the
  // heading theta.
  const double theta = state(PaperIndex::kTheta);
  const Eigen::Matrix2d R_theta = rotation2(theta);
  const Eigen::Vector2d step = R_theta * motion.start_from_end.position_m;
  const Eigen::Vector2d base = Eigen::Vector2d(state(PaperIndex::kDistance), 0.0) + step;
  const double distance = base.norm();
  const Eigen::RowVector2d J_distance_base = base.transpose() / distance;
  const Eigen::RowVector2d J_direction_base =
      perpendicular(base).transpose() / (distance * distance);

  PaperPropagation next{state, Matrix5::Identity(), Eigen::Matrix<double, 5, 3>::Zero()};
  next.state(PaperIndex::kDistance) = distance;
  next.state(PaperIndex::kTheta) =
      wrapAngle(theta + motion.start_from_end.yaw_rad - std::atan2(base.y(), base.x()));

  const Eigen::Vector2d J_base_theta = perpendicular(step);
  next.J_state_state.topLeftCorner<2, 2>() << J_distance_base.x(),
      J_distance_base.dot(J_base_theta), -J_direction_base.x(),
      1.0 - J_direction_base.dot(J_base_theta);
  next.J_state_motion.topLeftCorner<1, 2>() = J_distance_base * R_theta;
  next.J_state_motion.block<1, 2>(PaperIndex::kTheta, 0) = -J_direction_base * R_theta;
  next.J_state_motion(PaperIndex::kTheta, 2) = 1.0;
  return next;
}

AzimuthModel azimuthFromPaper(const Vector5& state) {
  const double distance = state(PaperIndex::kDistance);
  const double rho = state(PaperIndex::kRho);
  const double heading = state(PaperIndex::kTheta) + state(PaperIndex::kPhi);
  const double s = std::sin(heading);
  const double c = std::cos(heading);
  const double gamma = distance * distance + 2.0 * distance * rho * c + rho * rho;
  const double J_azimuth_heading = -distance * (distance + rho * c) / gamma;

  AzimuthModel model;
  model.azimuth_rad =
      wrapAngle(std::atan2(-rho * s, -distance - rho * c) - heading - state(PaperIndex::kPsi));
  model.J_azimuth_state << -rho * s / gamma, J_azimuth_heading, J_azimuth_heading,
      distance * s / gamma, -1.0;
  return model;
}

PaperFilter::PaperFilter(const PaperEstimate& start)
    : state_{{0, 1}, start.mean, start.covariance} {}

/// A motion changes D and theta alone, and by themselves alone.
void PaperFilter::predict(const OdometryIncrement& motion) {
  const PaperPropagation step = propagatePaper(state_.mean, motion);
  const Eigen::Matrix2d F = step.J_state_state.topLeftCorner<2, 2>();
  const Eigen::Matrix<double, 2, 3> G = step.J_state_motion.topRows<2>();
  StateMatrix& P = state_.covariance;
  state_.mean = step.state;
  P.topRows<2>() = (F * P.topRows<2>()).eval();
  P.leftCols<2>() = (P.leftCols<2>() * F.transpose()).eval();
  P.topLeftCorner<2, 2>() += G * motion.covariance * G.transpose();
}

void PaperFilter::update(double azimuth_rad, double azimuth_variance_rad2) {
  const AzimuthModel model = expectAzimuth();
  apply(prepareUpdate(model.J_azimuth_state, wrapAngle(azimuth_rad - model.azimuth_rad),
                      azimuth_variance_rad2, state_),
        &state_);
  for (int angle : {PaperIndex::kTheta, PaperIndex::kPhi, PaperIndex::kPsi}) {
    state_.mean(angle) = wrapAngle(state_.mean(angle));
  }
}

PaperEstimate PaperFilter::estimate() const {
  PaperEstimate estimate{mean(), covariance(), false};
  const double rho = estimate.mean(PaperIndex::kRho);
  if (rho < 0.0 || estimate.mean(PaperIndex::kDistance) < 0.0) {
    return paperFromCartesian(cartesianFromPaper(estimate));
  }
  estimate.phi_psi_determined =
      isRhoDetermined(rho, estimate.covariance(PaperIndex::kRho, PaperIndex::kRho));
  return estimate;
}

}  // namespace bearing_calibration::core
