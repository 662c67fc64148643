#pragma once

#include <optional>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/calibration/schedule.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/track/mount_tracker.h"

namespace bearing_calibration::core {

/// The initialiser's attempts on a record that grows, until one is ready.
class StartSearch {
 public:
  explicit StartSearch(const CalibratorConfig& config);

  void move(const OdometryIncrement& motion);
  bool isDue(const ObservationRecord& record) const { return !attempt_ || attempts_.isDue(record); }
  const StartAttempt& attempt(const Initializer& initializer);
  bool hasAttempted() const { return attempt_.has_value(); }
  /// Nothing explains the record, again and again, or the last answer is refuted.
  bool isInVain() const;
  /// A fault of the robot explains the record, which the last attempt's answer does by more noise.
  void refute() { is_refuted_ = true; }

  /// The last attempt's estimate, moved along, where it is right but not yet narrow enough for a
  /// linearised filter to take in bearings.
  const std::optional<MountTracker>& weak() const { return weak_; }
  /// Fills in state, advice and cause, once there was an attempt.
  void describe(CalibrationResult* result) const;

 private:
  FilterConfig weak_filter_;
  std::optional<StartAttempt> attempt_;  ///< the last one
  int misfits_ = 0;                      ///< attempts in a row after which nothing fitted
  bool is_refuted_ = false;              ///< the last attempt's answer
  Schedule attempts_;
  std::optional<MountTracker> weak_;
};

}  // namespace bearing_calibration::core
