#include "bearing_calibration/init/closed_form.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/cancellation.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/robust_loss.h"

namespace bearing_calibration::core {
namespace {

constexpr double kCapSigmas = 3.0;

/// Gradient and Hessian of half the cost.
struct NormalEquations {
  Vector5 gradient = Vector5::Zero();
  Matrix5 hessian = Matrix5::Zero();
};

FixedPathFit evaluate(const std::vector<PosedObservation>& observations, const Vector5& state,
                      const FixedPathWeight& weight, NormalEquations* normal) {
  const PosedObservation& reference = observations[weight.reference];
  FixedPathFit fit{state, 0.0, 0.0};
  for (const PosedObservation& observation : observations) {
    const Vector5 here = stateAt(observation, state);
    const AzimuthModel model = azimuthFromCartesian(here);
    const double stddev = bearingStddev(observation, reference, rangeOf(here));
    const double sigmas = wrapAngle(observation.azimuth_rad - model.azimuth_rad) / stddev;
    const Huber robust = huber(sigmas, weight.huber_sigmas);
    fit.cost += robust.cost;
    fit.capped_cost += std::min(sigmas * sigmas, kCapSigmas * kCapSigmas);
    if (normal == nullptr) continue;
    Eigen::Matrix<double, 1, 5> J = model.J_azimuth_state / stddev;
    J.head<2>() = (J.head<2>() * rotation2(-observation.first_from_base.yaw_rad)).eval();
    normal->gradient += sigmas / robust.doubt * J.transpose();
    normal->hessian.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose(), 1.0 / robust.doubt);
  }
  return fit;
}

}  // namespace

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

double rangeOf(const Vector5& state) { return (state.head<2>() - state.segment<2>(2)).norm(); }

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

double residualAt(const PosedObservation& observation, const Vector5& state_at_first) {
  return wrapAngle(observation.azimuth_rad -
                   azimuthFromCartesian(stateAt(observation, state_at_first)).azimuth_rad);
}

double bearingStddev(const PosedObservation& observation, const PosedObservation& reference,
                     double range_m) {
  // A light at the sensor itself would make the odometry's share infinite.
  constexpr double kLeastRange_m = 0.05;
  const double range = std::max(range_m, kLeastRange_m);
  const double heading =
      std::abs(observation.heading_variance_rad2 - reference.heading_variance_rad2);
  const double position =
      std::abs(observation.position_variance_m2 - reference.position_variance_m2);
  return std::sqrt(observation.azimuth_variance_rad2 + heading + position / (range * range));
}

FixedPathFit judgeOnFixedPath(const std::vector<PosedObservation>& observations,
                              const Vector5& state_at_first, const FixedPathWeight& weight) {
  return evaluate(observations, state_at_first, weight, nullptr);
}

FixedPathFit fitOnFixedPath(const std::vector<PosedObservation>& observations, const Vector5& start,
                            const FixedPathWeight& weight) {
  constexpr int kMaxIterations = 25;
  constexpr double kFirstDamping = 1e-3;
  constexpr double kLeastDamping = 1e-9;
  constexpr double kMostDamping = 1e6;
  constexpr double kDampingFactor = 5.0;
  constexpr double kSettledGain = 1e-3;  // of a cost in which 1 is one standard deviation
  double damping = kFirstDamping;
  NormalEquations normal;
  FixedPathFit best = evaluate(observations, start, weight, &normal);
  for (int i = 0; i < kMaxIterations && damping < kMostDamping; ++i) {
    endIfCancelled();
    Matrix5 damped = normal.hessian.selfadjointView<Eigen::Lower>();
    damped.diagonal() *= 1.0 + damping;
    const Vector5 state = best.state_at_first + damped.ldlt().solve(normal.gradient);
    NormalEquations next_normal;
    const FixedPathFit next = evaluate(observations, state, weight, &next_normal);
    if (!(next.cost < best.cost)) {
      damping *= kDampingFactor;
      continue;
    }
    const double gain = best.cost - next.cost;
    best = next;
    normal = next_normal;
    damping = std::max(damping / kDampingFactor, kLeastDamping);
    if (gain < kSettledGain) break;
  }
  best.state_at_first(CartesianIndex::kSensorYaw) =
      wrapAngle(best.state_at_first(CartesianIndex::kSensorYaw));
  return best;
}

}  // namespace bearing_calibration::core
