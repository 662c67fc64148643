#include "bearing_calibration/output/saving_rule.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {
namespace {

constexpr int kMountDegrees = 3;  // x, y and yaw

int rankOf(CalibrationState state) {
  if (state == CalibrationState::kConverged) return 2;
  return state == CalibrationState::kConverging ? 1 : 0;
}

/// The largest standard deviation of x, y and yaw, as a multiple of its target.
double worstStddev(const MountEstimate& mount, const ConvergenceConfig& targets) {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  return std::max(stddev.head<2>().maxCoeff() / targets.position_stddev_m,
                  stddev.z() / targets.yaw_stddev_rad);
}

std::string format(const char* text, double first, double second) {
  char buffer[200];  // longer than any of the sentences
  std::snprintf(buffer, sizeof(buffer), text, first, second);
  return buffer;
}

std::string comparedStates(const SavedCalibration& old, const SavedCalibration& fresh) {
  return std::string("it is ") + nameOf(old.state) + ", this one " + nameOf(fresh.state);
}

/// Why both are kept; empty when they are of one mount, as far as can be told.
std::string whyBothAreKept(const SavedCalibration& old, const SavedCalibration& fresh,
                           bool reset_between) {
  std::string why =
      whyOfAnotherRobot(old, fresh.base_frame, fresh.sensor_frame, fresh.provenance.drive);
  if (!why.empty()) return why;
  if (reset_between) return "the calibration was reset since";
  static const double kLargest = chiSquareQuantile(1.0 - kContradictionFalseAlarm, kMountDegrees);
  const double chi_square = disagreement(old.base_from_sensor, fresh.base_from_sensor);
  if (chi_square <= kLargest) return {};
  return format("it contradicts this one: chi-square %.1f of their difference, above %.1f",
                chi_square, kLargest);
}

}  // namespace

bool mayBeTrusted(CalibrationState state) { return rankOf(state) > 0; }

std::string whyOfAnotherRobot(const SavedCalibration& saved, const std::string& base_frame,
                              const std::string& sensor_frame, const DriveGeometry& drive) {
  const DriveGeometry& then = saved.provenance.drive;
  if (saved.base_frame != base_frame || saved.sensor_frame != sensor_frame) {
    return "it is of " + saved.base_frame + " and " + saved.sensor_frame;
  }
  if (then.wheel_separation_m != drive.wheel_separation_m ||
      then.left_wheel_radius_m != drive.left_wheel_radius_m ||
      then.right_wheel_radius_m != drive.right_wheel_radius_m) {
    return "it was measured with other wheels/separation, left_radius or right_radius";
  }
  return {};
}

SavingVerdict judgeSaving(const SavedCalibration& old, const SavedCalibration& fresh,
                          const ConvergenceConfig& targets, bool reset_between) {
  if (mayBeTrusted(old.state) && !mayBeTrusted(fresh.state)) {
    return {SavingDecision::kGivesWay, comparedStates(old, fresh)};
  }
  const std::string why = whyBothAreKept(old, fresh, reset_between);
  if (!why.empty()) return {SavingDecision::kTakesPlace, why};
  const int lead = rankOf(fresh.state) - rankOf(old.state);
  if (lead != 0) {
    return {lead > 0 ? SavingDecision::kReplaces : SavingDecision::kGivesWay,
            comparedStates(old, fresh)};
  }
  const double before = worstStddev(old.base_from_sensor, targets);
  const double now = worstStddev(fresh.base_from_sensor, targets);
  return {
      now <= before ? SavingDecision::kReplaces : SavingDecision::kGivesWay,
      format("its worst standard deviation is %.2f of its target, this one's %.2f", before, now)};
}

}  // namespace bearing_calibration::core
