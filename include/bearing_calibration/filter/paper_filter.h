#pragma once

#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/state.h"

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

/// The same knowledge in the paper's parametrisation (model.md, eq. 12). Where rho is not known
/// to be above zero, the variance of phi is limited to that of a direction of which nothing is
/// known.
PaperEstimate paperFromCartesian(const CartesianEstimate& cartesian);

/// The same knowledge in the Cartesian parametrisation (model.md, eq. 11).
CartesianEstimate cartesianFromPaper(const PaperEstimate& paper);

/// The paper's state after a motion, with its Jacobians by the state and by the increment's (x, y,
/// yaw) (model.md, eq. 9; the paper's eq. 12 for an exact arc). Not defined where the motion
/// ends at the light.
struct PaperPropagation {
  Vector5 state;
  Matrix5 J_state_state;
  Eigen::Matrix<double, 5, 3> J_state_motion;
};
PaperPropagation propagatePaper(const Vector5& state, const OdometryIncrement& motion);
/// Bearing from the paper's state (model.md, eq. 10; the paper's eqs. 8 and 15).
AzimuthModel azimuthFromPaper(const Vector5& state);

/// The paper's own filter on X = [D, theta, phi, rho, psi] (its section III), with the exact arc of
/// model.md, eq. 9. It may begin at rho = 0. It knows no errors of the robot.
class PaperFilter {
 public:
  explicit PaperFilter(const PaperEstimate& start);

  void predict(const OdometryIncrement& motion);
  AzimuthModel expectAzimuth() const { return azimuthFromPaper(state_.mean); }
  void update(double azimuth_rad, double azimuth_variance_rad2);
  /// Goes on from another mean with the covariance as it is.
  void setMean(const Vector5& mean) { state_.mean = mean; }

  Vector5 mean() const { return state_.mean; }
  Matrix5 covariance() const { return state_.covariance; }
  /// By its usual name: a negative D or rho, which an update may lead to, is the same place seen
  /// from the other side.
  PaperEstimate estimate() const;

 private:
  StateEstimate state_;  ///< its five numbers are those of the paper
};

}  // namespace bearing_calibration::core
