#include "support/yaw_scan.h"

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core::testing {
namespace {

/// The light is at l, the sensor at p in the base frame: with the line of a bearing known in the
/// first frame, its normal m obeys m . (l - t) = m . R p.
Vector5 solveAt(const std::vector<PosedObservation>& observations, double yaw_rad,
                const Vector5* last) {
  const auto rows = static_cast<Eigen::Index>(observations.size());
  Eigen::MatrixXd A(rows, 4);
  Eigen::VectorXd b(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const PosedObservation& observation = observations[static_cast<std::size_t>(i)];
    const Pose2& pose = observation.first_from_base;
    const double direction = pose.yaw_rad + yaw_rad + observation.azimuth_rad;
    const Eigen::RowVector2d normal(-std::sin(direction), std::cos(direction));
    double weight = 1.0;
    if (last != nullptr) {
      const Eigen::Vector2d sensor = pose * Eigen::Vector2d(last->segment<2>(2));
      weight = 1.0 / (last->head<2>() - sensor).norm();
    }
    A.row(i) << weight * normal, -weight * normal * rotation2(pose.yaw_rad);
    b(i) = weight * normal.dot(pose.position_m);
  }
  Vector5 state;
  state << A.colPivHouseholderQr().solve(b), yaw_rad;
  return state;
}

}  // namespace

double angularCost(const std::vector<PosedObservation>& observations,
                   const Vector5& state_at_first) {
  double cost = 0.0;
  for (const PosedObservation& observation : observations) {
    const Pose2 first_from_sensor =
        observation.first_from_base *
        Pose2{state_at_first.segment<2>(2), state_at_first(CartesianIndex::kSensorYaw)};
    const Eigen::Vector2d light =
        first_from_sensor.inverse() * Eigen::Vector2d(state_at_first.head<2>());
    cost += std::pow(wrapAngle(std::atan2(light.y(), light.x()) - observation.azimuth_rad), 2);
  }
  return cost;
}

Vector5 scanYaw(const std::vector<PosedObservation>& observations, int yaws) {
  Vector5 best = Vector5::Zero();
  double best_cost = std::numeric_limits<double>::infinity();
  for (int i = 0; i < yaws; ++i) {
    const double yaw = 2.0 * kPi * i / yaws;
    Vector5 state = solveAt(observations, yaw, nullptr);
    for (int pass = 0; pass < 2; ++pass) state = solveAt(observations, yaw, &state);
    const double cost = angularCost(observations, state);
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = state;
  }
  best(CartesianIndex::kSensorYaw) = wrapAngle(best(CartesianIndex::kSensorYaw));
  return best;
}

}  // namespace bearing_calibration::core::testing
