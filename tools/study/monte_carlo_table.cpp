#include "tools/study/monte_carlo_table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/robust_statistics.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {
namespace {

constexpr int kMountDegrees = 3;
constexpr int kStateDegrees = 5;

Eigen::Matrix<double, 6, 1> errorsOf(const Snapshot& snapshot) {
  Eigen::Matrix<double, 6, 1> errors;
  errors << snapshot.polar_error, snapshot.psi_error_rad, snapshot.error.tail<3>();
  return errors;
}

Eigen::Matrix<double, 6, 1> boundsOf(const Snapshot& snapshot) {
  Eigen::Matrix<double, 6, 1> bounds;
  bounds << snapshot.polar_bound, snapshot.bound.diagonal().tail<3>();
  return bounds;
}

TableRow summariseRow(const std::vector<Trial>& trials, std::size_t index) {
  TableRow row;
  std::map<std::string, int> words;
  Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> bounds = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Vector3d off_whole = Eigen::Vector3d::Zero();  // squares
  Eigen::Vector3d bounds_of_whole = Eigen::Vector3d::Zero();
  for (const Trial& trial : trials) {
    const Snapshot& snapshot = trial.snapshots[index];
    row.time_s = snapshot.time_s;
    ++row.trials;
    ++words[snapshot.words];
    row.milliseconds += snapshot.milliseconds;
    row.most_milliseconds = std::max(row.most_milliseconds, snapshot.milliseconds);
    row.possible += snapshot.possible ? 1 : 0;
    row.possible_claimed += snapshot.possible && snapshot.claims ? 1 : 0;
    if (snapshot.has_estimate) {
      squares += errorsOf(snapshot).cwiseAbs2();
      bounds += boundsOf(snapshot);
      ++row.estimates;
      row.estimate_nees += snapshot.mountChiSquare();
      row.failed += snapshot.failed() ? 1 : 0;
    }
    if (snapshot.off_whole_record) {
      ++row.whole;
      off_whole += snapshot.off_whole_record->cwiseAbs2();
      bounds_of_whole += snapshot.bound.diagonal().tail<3>();
    }
    if (!snapshot.claims) continue;
    ++row.claimed;
    const double chi_square = snapshot.mountChiSquare();
    row.wrong += snapshot.failed() ? 1 : 0;
    row.beyond += chi_square > kEllipsoidChiSquare ? 1 : 0;
    row.mount_nees += chi_square;
    row.state_nees += snapshot.stateChiSquare();
  }
  row.milliseconds /= std::max(1, row.trials);
  row.mount_nees /= kMountDegrees * std::max(1, row.claimed);
  row.state_nees /= kStateDegrees * std::max(1, row.claimed);
  row.estimate_nees /= kMountDegrees * std::max(1, row.estimates);
  row.rmse_per_bound = (squares.array() / bounds.array()).sqrt();
  if (row.whole > 0) {
    row.off_whole_per_bound = (off_whole.array() / bounds_of_whole.array()).sqrt();
  }
  for (const auto& [word, count] : words) {
    row.words += (row.words.empty() ? "" : ", ") + word + " " + std::to_string(count);
  }
  return row;
}

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

std::vector<TableRow> summarise(const std::vector<Trial>& trials) {
  std::vector<TableRow> rows;
  if (trials.empty()) return rows;
  for (std::size_t i = 0; i < trials.front().snapshots.size(); ++i) {
    rows.push_back(summariseRow(trials, i));
  }
  return rows;
}

std::string formatBounds(const std::vector<Trial>& trials) {
  std::string text =
      "| time [s] | bound phi [deg] | rho [mm] | psi [deg] | yaw [deg] | RMSE phi [deg] | rho [mm] "
      "| "
      "psi [deg] | yaw [deg] |\n|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; !trials.empty() && i < trials.front().snapshots.size(); ++i) {
    Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();
    Eigen::Matrix<double, 6, 1> bounds = Eigen::Matrix<double, 6, 1>::Zero();
    int estimates = 0;
    for (const Trial& trial : trials) {
      if (!trial.snapshots[i].has_estimate) continue;
      ++estimates;
      squares += errorsOf(trial.snapshots[i]).cwiseAbs2();
      bounds += boundsOf(trial.snapshots[i]);
    }
    const auto shown = [&](const Eigen::Matrix<double, 6, 1>& sums) {
      const Eigen::Matrix<double, 6, 1> size = (sums / std::max(1, estimates)).cwiseSqrt();
      return Eigen::Vector4d(degreesFromRadians(size(0)), kMillimetresPerMetre * size(1),
                             degreesFromRadians(size(2)), degreesFromRadians(size(5)));
    };
    const Eigen::Vector4d bound = shown(bounds);
    const Eigen::Vector4d reached = shown(squares);
    text += formatted("| %.0f | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f |\n",
                      trials.front().snapshots[i].time_s, bound(0), bound(1), bound(2), bound(3),
                      reached(0), reached(1), reached(2), reached(3));
  }
  return text;
}

std::string formatClaims(const std::vector<Trial>& trials) {
  std::vector<double> first_s;
  for (const Trial& trial : trials) {
    if (trial.first_claim_s) first_s.push_back(*trial.first_claim_s);
  }
  if (first_s.empty()) return "never declared\n";
  return formatted("declared at any time: %zu of %zu, first after %.0f s (median), %.0f s (last)\n",
                   first_s.size(), trials.size(), medianOf(first_s),
                   *std::max_element(first_s.begin(), first_s.end()));
}

std::string formatErrors(const std::vector<Trial>& trials) {
  constexpr double kMostRmse = 3.0;
  std::string text =
      "| time [s] | estimates | position off, median, RMSE [mm] | yaw, median [deg] | standard "
      "deviation at most 3 RMSE |\n|---|---|---|---|---|\n";
  for (std::size_t i = 0; !trials.empty() && i < trials.front().snapshots.size(); ++i) {
    std::vector<double> off_m, yaw_rad, stddev_m;
    double squares_m2 = 0.0;
    for (const Trial& trial : trials) {
      const Snapshot& snapshot = trial.snapshots[i];
      if (!snapshot.has_estimate) continue;
      off_m.push_back(snapshot.error.segment<2>(CartesianIndex::kSensorX).norm());
      yaw_rad.push_back(std::abs(snapshot.error(CartesianIndex::kSensorYaw)));
      stddev_m.push_back(
          std::sqrt(snapshot.covariance.diagonal().segment<2>(CartesianIndex::kSensorX).sum()));
      squares_m2 += off_m.back() * off_m.back();
    }
    if (off_m.empty()) continue;
    const double rmse_m = std::sqrt(squares_m2 / static_cast<double>(off_m.size()));
    const auto usable = std::count_if(stddev_m.begin(), stddev_m.end(),
                                      [&](double stddev) { return stddev <= kMostRmse * rmse_m; });
    text +=
        formatted("| %.0f | %zu | %.1f, %.1f | %.2f | %td |\n", trials.front().snapshots[i].time_s,
                  off_m.size(), kMillimetresPerMetre * medianOf(off_m),
                  kMillimetresPerMetre * rmse_m, degreesFromRadians(medianOf(yaw_rad)), usable);
  }
  return text;
}

std::string format(const std::vector<TableRow>& rows) {
  std::string text =
      "| time [s] | possible | declared of these | declared | wrong | beyond 99 % | NEES/3 | "
      "NEES/5 | NEES/3 of all estimates | failed | RMSE/bound phi, rho, psi, x, y, yaw | "
      "ms mean, most | states |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const TableRow& row : rows) {
    const Eigen::Matrix<double, 6, 1>& q = row.rmse_per_bound;
    text += formatted(
        "| %.0f | %d of %d | %d | %d | %d | %d | %.2f | %.2f | %.2f | %d | %.2f %.2f "
        "%.2f %.2f %.2f %.2f | %.1f, %.0f | %s |\n",
        row.time_s, row.possible, row.trials, row.possible_claimed, row.claimed, row.wrong,
        row.beyond, row.mount_nees, row.state_nees, row.estimate_nees, row.failed, q(0), q(1), q(2),
        q(3), q(4), q(5), row.milliseconds, row.most_milliseconds, row.words.c_str());
  }
  return text;
}

std::string formatWhole(const std::vector<TableRow>& rows) {
  std::string text;
  for (const TableRow& row : rows) {
    if (row.whole == 0) continue;
    const Eigen::Vector3d& q = row.off_whole_per_bound;
    text += formatted("| %.0f | %d | %.2f %.2f %.2f |\n", row.time_s, row.whole, q(0), q(1), q(2));
  }
  if (text.empty()) return text;
  return "| time [s] | whole records fitted | RMS off that fit/bound x y yaw |\n|---|---|---|\n" +
         text;
}

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
