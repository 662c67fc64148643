#pragma once

#include <string>
#include <vector>

#include "tools/study/monte_carlo_trials.h"

namespace bearing_calibration::core {

/// Quantile of 99 % of the same distribution.
inline constexpr double kEllipsoidChiSquare = 11.345;

/// One moment over all trials.
struct TableRow {
  double time_s = 0.0;
  int trials = 0;
  int possible = 0;          ///< trials whose bound allows the claim
  int possible_claimed = 0;  ///< of these, claimed
  int claimed = 0;
  int wrong = 0;            ///< claimed and failed
  int beyond = 0;           ///< claimed, beyond the 99 % ellipsoid
  double mount_nees = 0.0;  ///< mean over the claims, per degree of freedom
  double state_nees = 0.0;
  int estimates = 0;           ///< whether claimed or not
  double estimate_nees = 0.0;  ///< mean over these, of the mount, per degree of freedom
  int failed = 0;              ///< of these
  /// RMSE over the square root of the mean bound, over the trials with an estimate: phi, rho, psi,
  /// x, y, yaw.
  Eigen::Matrix<double, 6, 1> rmse_per_bound = Eigen::Matrix<double, 6, 1>::Zero();
  int whole = 0;  ///< trials whose whole record was fitted, too
  /// RMS of the estimates less those fits, over the square root of the mean bound: x, y, yaw.
  Eigen::Vector3d off_whole_per_bound = Eigen::Vector3d::Zero();
  double milliseconds = 0.0;  ///< of CPU time, mean
  double most_milliseconds = 0.0;
  std::string words;  ///< how often which state or reason
};

std::vector<TableRow> summarise(const std::vector<Trial>& trials);
/// A table in Markdown.
std::string format(const std::vector<TableRow>& rows);
/// How far the estimates are from fits of the whole records; empty where none was fitted.
std::string formatWhole(const std::vector<TableRow>& rows);
/// The bound and what was reached, as absolute figures: standard deviations over all trials with an
/// estimate.
std::string formatBounds(const std::vector<Trial>& trials);

/// How many trials were declared at any time, and after how long first: a line.
std::string formatClaims(const std::vector<Trial>& trials);
/// How many trials have an estimate, how far off it is, and how many have one that says something:
/// its standard deviation of the position is at most three times the RMSE of all.
std::string formatErrors(const std::vector<Trial>& trials);

/// One line for each quantity of mount and robot that was estimated, at the runs' end, over those
/// that claim: bias and scatter in units of the standard deviations that they stated; and the
/// mount's errors by themselves. Empty when no error of the robot was looked for.
std::string formatRobotErrors(const std::vector<Trial>& trials);

}  // namespace bearing_calibration::core
