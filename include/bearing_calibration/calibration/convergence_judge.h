#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/batch_estimator.h"
#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/calibration/mount_tracker.h"
#include "bearing_calibration/calibration/result.h"

namespace bearing_calibration {

/// What may be said of a running filter, with a sentence for the driver.
struct Judgement {
  CalibrationState state = CalibrationState::kConverging;
  std::string advice;
  bool knocked = false;  ///< inconsistent because the mount has moved since it was converged
};

/// Decides whether a filter that carries on from a good start has converged, and whether what it is
/// fed still fits. Converged needs all of: standard deviations within the targets, innovations that
/// are consistent, and two halves of the record that give the same mount, each for itself. From
/// then on the most recent motion is held against that mount, so that a knock is noticed.
class ConvergenceJudge {
 public:
  ConvergenceJudge(const ConvergenceConfig& config, const BatchConfig& batch);

  /// @param record  the sights so far, thinned or not
  /// @param settled  the batch over them, which the tracker has just taken up; none when it did not
  ///   settle: nothing is called converged then
  void judge(const MountTracker& tracker, const std::vector<Sight>& record,
             const std::optional<BatchEstimate>& settled);
  const Judgement& last() const { return last_; }

 private:
  std::optional<std::string> inconsistency(const Consistency& recent) const;
  Judgement decide(const MountTracker& tracker, const std::vector<Sight>& record,
                   const std::optional<BatchEstimate>& settled);
  Judgement confirm(const CartesianEstimate& estimate, const std::vector<Sight>& record);
  Judgement watch(const CartesianEstimate& estimate, const std::vector<Sight>& record);
  /// By what the last stretch of way contradicts all before it; none when it does not.
  std::optional<Eigen::Vector3d> findMove(const CartesianEstimate& estimate,
                                          const std::vector<Sight>& record) const;
  bool meetsTargets(const MountEstimate& mount) const;
  Judgement stillConverging(const CartesianEstimate& estimate) const;

  ConvergenceConfig config_;
  BatchConfig batch_;
  Judgement last_;
  bool confirmed_ = false;  ///< it was called converged
  int disagreements_in_a_row_ = 0;
};

}  // namespace bearing_calibration
