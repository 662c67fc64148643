#include "tools/study/drive_summary.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

constexpr double kMostFigure = 0.25;
constexpr double kTail = 1e-3;

Eigen::Vector3d mountError(const DriveRecord& record) {
  return mountDifference(record.result.cartesian_state->mean.tail<3>(), record.truth.tail<3>());
}

Eigen::Matrix3d mountCovariance(const DriveRecord& record) {
  return record.result.cartesian_state->covariance.bottomRightCorner<3, 3>();
}

double chiSquareOf(const DriveRecord& record) {
  const Eigen::Vector3d error = mountError(record);
  return error.dot(mountCovariance(record).ldlt().solve(error));
}

/// From (x, y, yaw) to axes along and across the true mount, which all runs have in common.
Eigen::Matrix3d alongMount(const Vector5& truth) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = rotation2(-std::atan2(truth(3), truth(2)));
  return turn;
}

Bar atMost(const std::string& sentence, double value, double limit) {
  return {sentence, value, limit, value <= limit};
}

}  // namespace

const std::vector<DrivenMotion>& comparedMotions() {
  static const std::vector<DrivenMotion> motions = {
      {"planned", DriveMotion::kOptimal, {0.0, 2.0}, 0.5},
      {"paper's dance", DriveMotion::kDance, {0.0, 2.0}, 0.5},
      {"corner light, 0.5 m", DriveMotion::kCornerLight, {0.5, 0.5}, 0.4},
      {"corner light, 0.3 m", DriveMotion::kCornerLight, {0.7, 0.3}, 0.2},
  };
  return motions;
}

DrivenCase motionCase(const DrivenMotion& motion, std::uint64_t seed, double duration_s) {
  constexpr double kAnyPath_m = 1000.0;
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  const double phi = angle(engine);
  DrivenCase driven;
  driven.simulated = paperCase(seed);
  RobotConfig& robot = driven.simulated.robot;
  robot.base_from_sensor = {rotation2(phi) * Eigen::Vector2d(kPaperRho_m, 0.0), angle(engine)};
  driven.simulated.lights = {Light{robot.world_from_start * motion.light_in_start_m}};
  driven.drive = paperDrive();
  driven.drive.planner.light_distance_m = motion.light_distance_m;
  driven.goal = {motion.motion, duration_s, kAnyPath_m};
  driven.stops_when_converged = false;
  return driven;
}

namespace {

DrivenCase roomOf(std::uint64_t seed, const RandomCaseRange& range) {
  constexpr double kMostTime_s = 300.0;
  constexpr double kMostPath_m = 60.0;
  DrivenCase driven;
  driven.simulated = randomCase(seed, TrajectoryConfig::Kind::kStanding, range);
  driven.drive = paperDrive();
  driven.goal = {DriveMotion::kOptimal, kMostTime_s, kMostPath_m};
  return driven;
}

}  // namespace

DrivenCase roomCase(std::uint64_t seed) { return roomOf(seed, {0.5, 0.5, 3.0}); }

DrivenCase farRoomCase(std::uint64_t seed) {
  DrivenCase driven = roomOf(seed, {0.5, 2.5, 6.0});
  driven.simulated.looked_for = usualErrors();
  return driven;
}

DrivenCase viewCase(std::uint64_t seed, double width_rad, bool is_known) {
  constexpr double kPatience_s = 60.0;
  DrivenCase driven = roomCase(seed);
  driven.view.width_rad = width_rad;
  driven.is_view_known = is_known;
  if (!is_known) driven.drive.timeouts.bearings_s = kPatience_s;
  return driven;
}

MotionSummaryRow summarise(const std::vector<DriveRecord>& records) {
  MotionSummaryRow row;
  row.runs = static_cast<int>(records.size());
  row.least_distance_m = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d errors = Eigen::Matrix3d::Zero();
  for (const DriveRecord& record : records) {
    row.least_distance_m = std::min(row.least_distance_m, record.least_distance_m);
    row.worst_decision_ms = std::max(row.worst_decision_ms, record.worst_decision_ms);
    if (!record.result.cartesian_state) {
      ++row.without_estimate;
      continue;
    }
    const double figure = polarFigure(mountCovariance(record), kPaperRho_m);
    row.figure += figure;
    row.worst_figure = std::max(row.worst_figure, figure);
    row.nees += chiSquareOf(record);
    const Eigen::Vector3d error = alongMount(record.truth) * mountError(record);
    errors += error * error.transpose();
  }
  const double count = row.runs - row.without_estimate;
  row.figure /= count;
  row.nees /= count;
  row.measured_figure = polarFigure(errors / count, kPaperRho_m);
  return row;
}

std::string formatEach(const std::vector<DriveRecord>& records) {
  std::string lines;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const DriveRecord& record = records[i];
    lines += formatted("  run %zu: %s after %.1f s, ", i + 1, nameOf(record.end), record.time_s);
    if (record.result.cartesian_state) {
      lines +=
          formatted("figure %.3f, chi-square %.1f, first estimate after %.1f s, nearest %.2f m\n",
                    polarFigure(mountCovariance(record), kPaperRho_m), chiSquareOf(record),
                    record.first_estimate_s, record.least_distance_m);
    } else {
      lines += "no estimate\n";
    }
  }
  return lines;
}

std::string motionHeader() {
  return formatted("%-20s %5s %7s %7s %9s %6s %9s %9s\n", "motion", "runs", "figure", "worst",
                   "measured", "NEES", "nearest m", "decide ms");
}

std::string format(const std::string& name, const MotionSummaryRow& row) {
  return formatted("%-20s %5d %7.3f %7.3f %9.3f %6.2f %9.3f %9.2f\n", name.c_str(), row.runs,
                   row.figure, row.worst_figure, row.measured_figure, row.nees,
                   row.least_distance_m, row.worst_decision_ms);
}

std::vector<Bar> judgeBars(const MotionSummaryRow& row) {
  constexpr double kDimensions = 3.0;  // x, y and yaw
  const double estimates = row.runs - row.without_estimate;
  const double all = kDimensions * estimates;
  return {
      atMost("runs without an estimate", row.without_estimate, 0.0),
      atMost("figure", row.figure, kMostFigure),
      atMost("mean NEES", row.nees, chiSquareQuantile(1.0 - kTail, all) / estimates),
      atMost("NEES, at least", chiSquareQuantile(kTail, all) / estimates, row.nees),
      atMost("nearness to the light, 1/m", 1.0 / row.least_distance_m, 1.0 / kNear_m),
  };
}

RoomSummary summariseRooms(const std::vector<DriveRecord>& records) {
  const double most_chi_square = chiSquareQuantile(1.0 - kTail, 3.0);
  RoomSummary summary;
  summary.rooms = static_cast<int>(records.size());
  double images = 0.0;
  double images_with_light = 0.0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const DriveRecord& record = records[i];
    images += record.images;
    images_with_light += record.images_with_light;
    summary.mean_time_s += record.time_s / summary.rooms;
    summary.worst_time_s = std::max(summary.worst_time_s, record.time_s);
    if (record.least_kept_distance_m < kNear_m) {
      ++summary.near_when_planned;
    } else if (record.least_distance_m < kNear_m) {
      ++summary.near_in_opening;
    }
    if (record.end != DriveEnd::kConverged) {
      summary.failures += formatted("  room %zu: %s after %.0f s, %s\n", i + 1, nameOf(record.end),
                                    record.time_s, record.result.advice.c_str());
      continue;
    }
    ++summary.converged;
    const double chi_square = chiSquareOf(record);
    summary.nees += chi_square;
    if (chi_square < most_chi_square) ++summary.right;
  }
  summary.nees /= summary.converged;
  summary.share_in_view = images_with_light / images;
  return summary;
}

std::string format(const RoomSummary& summary) {
  return formatted(
             "rooms: %d of %d converged (%d of them right), mean %.0f s, longest %.0f s\n"
             "nearer than %.2f m: %d before the first plan, %d when planned\n",
             summary.converged, summary.rooms, summary.right, summary.mean_time_s,
             summary.worst_time_s, kNear_m, summary.near_in_opening, summary.near_when_planned) +
         summary.failures;
}

std::string viewHeader() {
  return formatted("%8s %8s %9s %9s %7s %6s %9s %6s %6s\n", "view deg", "planner", "rooms",
                   "converged", "right", "mean s", "longest s", "seen %", "NEES");
}

std::string formatView(double width_rad, bool is_known, const RoomSummary& summary) {
  constexpr double kPercent = 100.0;
  return formatted("%8.0f %8s %9d %9d %7d %6.0f %9.0f %6.0f %6.2f\n", degreesFromRadians(width_rad),
                   is_known ? "knows" : "does not", summary.rooms, summary.converged, summary.right,
                   summary.mean_time_s, summary.worst_time_s, kPercent * summary.share_in_view,
                   summary.nees) +
         summary.failures;
}

std::vector<Bar> judgeBars(const RoomSummary& summary) {
  constexpr double kMostFailures = 0.01;
  return {atMost("rooms without convergence", summary.rooms - summary.converged,
                 kMostFailures * summary.rooms),
          atMost("rooms converged to a wrong mount", summary.converged - summary.right, 0.0),
          atMost("rooms nearer to the light than allowed when planned", summary.near_when_planned,
                 0.0)};
}

}  // namespace bearing_calibration::core
