#include "tools/robot_error_table.h"

#include <cmath>
#include <cstdio>

#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration {
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
    char text[128];
    std::snprintf(text, sizeof(text), "%-30s %6d %8.2f %8.2f %12.5f\n", name.c_str(), count,
                  error / count, std::sqrt(square / count), stddev / count);
    return text;
  }
};

}  // namespace

std::string formatRobotErrors(const std::vector<Trial>& trials) {
  std::vector<Column> mount = {{"x [m]"}, {"y [m]"}, {"yaw [rad]"}};
  std::vector<Column> robot;
  for (const std::string& name : errorNames()) robot.push_back({name});
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
  return header + lines;
}

}  // namespace bearing_calibration
