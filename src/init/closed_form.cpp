#include "bearing_calibration/init/closed_form.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration::core {

void ClosedForm::add(const PosedObservation& observation, double weight) {
  const Eigen::Vector2d across(-std::sin(observation.azimuth_rad),
                               std::cos(observation.azimuth_rad));
  const Eigen::Vector2d across_in_first = rotation2(observation.first_from_base.yaw_rad) * across;
  const Eigen::Vector2d& t = observation.first_from_base.position_m;
  Eigen::Matrix<double, 6, 1> row;
  row << across_in_first, -across, -across_in_first.dot(t), across_in_first.dot(perpendicular(t));
  moment_.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
}

std::optional<Vector5> ClosedForm::solve() const {
  const Eigen::Matrix<double, 6, 6> moment = moment_.selfadjointView<Eigen::Lower>();
  const Eigen::LDLT<Eigen::Matrix4d> positions(moment.topLeftCorner<4, 4>());
  const Eigen::Matrix<double, 4, 2> coupling = moment.topRightCorner<4, 2>();
  const Eigen::Matrix2d reduced =
      moment.bottomRightCorner<2, 2>() - coupling.transpose() * positions.solve(coupling);
  if (!reduced.allFinite()) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(reduced);
  return stateFor(solver.eigenvectors().col(0));
}

std::optional<Vector5> ClosedForm::solveFor(double sensor_yaw_rad) const {
  return stateFor({std::cos(sensor_yaw_rad), std::sin(sensor_yaw_rad)});
}

std::optional<Vector5> ClosedForm::stateFor(const Eigen::Vector2d& yaw_direction) const {
  const Eigen::Matrix<double, 6, 6> moment = moment_.selfadjointView<Eigen::Lower>();
  const Eigen::Vector4d positions =
      -moment.topLeftCorner<4, 4>().ldlt().solve(moment.topRightCorner<4, 2>() * yaw_direction);
  const double yaw = std::atan2(yaw_direction.y(), yaw_direction.x());
  const Eigen::Matrix2d R = rotation2(yaw);
  Vector5 state;
  state << R * positions.head<2>(), R * positions.tail<2>(), yaw;
  if (!state.allFinite()) return std::nullopt;
  return state;
}

Vector5 stateAt(const PosedObservation& observation, const Vector5& state_at_first) {
  Vector5 state = state_at_first;
  state.head<2>() =
      observation.first_from_base.inverse() * Eigen::Vector2d(state_at_first.head<2>());
  return state;
}

Vector5 withLightInFront(const std::vector<PosedObservation>& observations,
                         const Vector5& state_at_first) {
  double in_front = 0.0;
  for (const PosedObservation& observation : observations) {
    in_front += std::cos(observation.azimuth_rad -
                         azimuthFromCartesian(stateAt(observation, state_at_first)).azimuth_rad);
  }
  Vector5 state = state_at_first;
  if (in_front < 0.0) {
    state(CartesianIndex::kSensorYaw) = wrapAngle(state(CartesianIndex::kSensorYaw) + kPi);
  }
  return state;
}

}  // namespace bearing_calibration::core
