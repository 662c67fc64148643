#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/study/driven_case.h"
#include "tools/study/monte_carlo_bars.h"

namespace bearing_calibration::core {

inline constexpr double kPaperRho_m = 0.1;  ///< the mount's distance from the base, in the paper

/// A way to drive, and where the light stands in the frame of the start.
struct DrivenMotion {
  std::string name;
  DriveMotion motion;
  Eigen::Vector2d light_in_start_m;
  double light_distance_m;  ///< to be kept
};

/// The planned motion first, then the paper's dance and the corner-light rule.
const std::vector<DrivenMotion>& comparedMotions();

/// The paper's robot and noise with a mount of the paper's rho, turned anyhow by the seed.
DrivenCase motionCase(const DrivenMotion& motion, std::uint64_t seed, double duration_s);
/// Any mount up to half a metre out, the light anywhere in 0.5 to 3 m; drives until converged.
DrivenCase roomCase(std::uint64_t seed);
/// The same with the light anywhere in 2.5 to 6 m, and a calibration that looks for the robot's
/// errors, as config/calibration.yaml has it.
DrivenCase farRoomCase(std::uint64_t seed);

/// What runs of one motion came to. Figures are det cov(phi deg, rho mm, psi deg)^(1/6).
struct MotionSummaryRow {
  int runs = 0;
  int without_estimate = 0;
  double figure = 0.0;           ///< of the covariance that the calibration states, mean
  double worst_figure = 0.0;     ///< of all runs
  double measured_figure = 0.0;  ///< of the errors themselves
  double nees = 0.0;             ///< mean of chi-square over 3 degrees of freedom: 3 when honest
  double least_distance_m = 0.0;
  double worst_decision_ms = 0.0;
};

MotionSummaryRow summarise(const std::vector<DriveRecord>& records);
std::string motionHeader();
/// A line for each run, in the order of their seeds: which one is worse than the others, and why.
std::string formatEach(const std::vector<DriveRecord>& records);
std::string format(const std::string& name, const MotionSummaryRow& row);
std::vector<Bar> judgeBars(const MotionSummaryRow& row);

/// A room with a sensor that sees so much of a turn, about its x axis.
/// @param is_known  it says so; else the drive bears that the light is out of view for long
DrivenCase viewCase(std::uint64_t seed, double width_rad, bool is_known);

struct RoomSummary {
  int rooms = 0;
  int converged = 0;
  double mean_time_s = 0.0;
  double worst_time_s = 0.0;
  int right = 0;            ///< of those that converged: within the tail of one in a thousand
  int near_in_opening = 0;  ///< nearer than the bar, when nothing was known of the light
  int near_when_planned = 0;
  double share_in_view = 0.0;  ///< of the images, those with the light
  double nees = 0.0;           ///< of those that converged, as in MotionSummaryRow
  std::string failures;        ///< a line for each room that did not converge
};

RoomSummary summariseRooms(const std::vector<DriveRecord>& records);
std::string format(const RoomSummary& summary);
std::vector<Bar> judgeBars(const RoomSummary& summary);

std::string viewHeader();
std::string formatView(double width_rad, bool is_known, const RoomSummary& summary);

}  // namespace bearing_calibration::core
