#pragma once

#include <Eigen/Core>

#include "bearing_calibration/filter/cartesian_state.h"

namespace bearing_calibration::core {

/// Positions of the quantities in the paper's state X = [D, theta, phi, rho, psi] (paper, eq. 11):
/// D distance from the light to the base, theta base heading minus the direction from the light to
/// the base, (rho, phi) the sensor's position in the base frame, psi the sensor's yaw minus phi.
struct PaperIndex {
  enum : int { kDistance = 0, kTheta = 1, kPhi = 2, kRho = 3, kPsi = 4 };
};

/// Mean [m, rad, rad, m, rad] and covariance of the paper's state.
struct PaperEstimate {
  Vector5 mean = Vector5::Zero();
  Matrix5 covariance = Matrix5::Zero();
  /// False where rho is not clearly above zero: phi and psi alone mean nothing then.
  bool phi_psi_determined = false;
};

/// The sensor's pose in the base frame. mean = (x [m], y [m], yaw [rad]).
struct MountEstimate {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// The same knowledge in the paper's parametrisation (doc/model.md, eq. 12). Where rho is not known
/// to be above zero, the variance of phi is limited to that of a direction of which nothing is
/// known.
PaperEstimate paperFromCartesian(const CartesianEstimate& cartesian);

/// The same knowledge in the Cartesian parametrisation (doc/model.md, eq. 11).
CartesianEstimate cartesianFromPaper(const PaperEstimate& paper);

/// The sensor's part of the state (doc/model.md, eq. 13): x = rho cos phi, y = rho sin phi,
/// yaw = phi + psi.
MountEstimate mountFromCartesian(const CartesianEstimate& cartesian);

/// Whether rho is so clearly above zero that phi and psi mean something.
bool isRhoDetermined(double rho_m, double rho_variance_m2);

}  // namespace bearing_calibration::core
