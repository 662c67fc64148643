#include "tools/study/robot_error_table.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {
namespace {

/// Sums of one quantity's errors over its stated standard deviations.
struct Column {
  std::string name;
  int count = 0;
  double error = 0.0;
  double square = 0.0;
  double stddev = 0.0;

  void add(double value, double stated) {
    if (!(stated > 0.0)) return;
    ++count;
    error += value / stated;
    square += value * value / (stated * stated);
    stddev += stated;
  }

  std::string line() const {
    return formatted("%-30s %6d %8.2f %8.2f %12.5f\n", name.c_str(), count, error / count,
                     std::sqrt(square / count), stddev / count);
  }
};

/// The mount's errors by themselves.
std::string mountErrors(const std::vector<Trial>& trials) {
  int count = 0;
  Eigen::Array4d squares = Eigen::Array4d::Zero();  // phi, rho, psi, yaw
  for (const Trial& trial : trials) {
    const Snapshot& last = trial.snapshots.back();
    if (!last.claims) continue;
    ++count;
    squares += Eigen::Array4d(last.polar_error.x(), last.polar_error.y(), last.psi_error_rad,
                              last.error(CartesianIndex::kSensorYaw))
                   .square();
  }
  const Eigen::Array4d rmse = (squares / count).sqrt();
  return formatted("RMSE of phi %.2f deg, rho %.2f mm, psi %.2f deg, yaw %.3f deg\n",
                   degreesFromRadians(rmse(0)), kMillimetresPerMetre * rmse(1),
                   degreesFromRadians(rmse(2)), degreesFromRadians(rmse(3)));
}

}  // namespace

std::string formatRobotErrors(const std::vector<Trial>& trials) {
  std::vector<Column> mount = {{"x [m]"}, {"y [m]"}, {"yaw [rad]"}};
  std::vector<Column> robot;
  for (const Quantity& error : errorQuantities()) robot.push_back({labelOf(error)});
  for (const Trial& trial : trials) {
    const Snapshot& last = trial.snapshots.back();
    if (!last.claims) continue;
    for (int i = 0; i < 3; ++i) {
      const int at = CartesianIndex::kSensorX + i;
      mount[static_cast<std::size_t>(i)].add(last.error(at), std::sqrt(last.covariance(at, at)));
    }
    for (int i = 0; i < kErrorCount; ++i) {
      robot[static_cast<std::size_t>(i)].add(last.robot_error(i), last.robot_stddev(i));
    }
  }
  std::string lines;
  for (const Column& column : robot) {
    if (column.count > 0) lines += column.line();
  }
  if (lines.empty()) return "";
  std::string header = "quantity                         runs  bias/sd  rmse/sd      mean sd\n";
  for (const Column& column : mount) header += column.line();
  return header + lines + mountErrors(trials);
}

}  // namespace bearing_calibration::core
