#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/record_weights.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {

/// One fit of one record, from the start to the end of its iterations. Slips are looked for as soon
/// as the fit is near; then the weights go from Huber's to plain ones without the outliers.
class BatchFit {
 public:
  BatchFit(const std::vector<Observation>& observations, const RecordTrack& track,
           const BatchConfig& config, const SlipHypothesis& slips,
           const std::optional<RecordBeginning>& beginning);

  BatchEstimate run();

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  enum class Stage { kHuber, kRejecting, kWidening, kDone };

  bool step(int iteration);
  bool goesBack(const StateVector& change, const StateMatrix& covariance) const;
  void weighAnew();
  double costOf(const SmootherPass& pass, const RecordPath& path) const;
  bool hasLikelyErrors() const;
  bool hasSettled() const;
  void nextStage();
  void judgeInnovations(BatchEstimate& estimate) const;

  const BatchConfig& config_;
  const std::vector<Observation>& observations_;
  const std::optional<RecordBeginning>& beginning_;
  RecordWeights weights_;
  RecordPath path_;
  SmootherPass pass_;
  SmootherPass settled_;  ///< before the variances were widened: what the fit is judged by
  Stage stage_ = Stage::kHuber;
  double cost_ = kInfinity;       ///< of path_, by the present weights; not known yet
  double last_step_ = kInfinity;  ///< of mount and lights at the end, squared over its covariance
  double last_mount_step_ = kInfinity;
  std::optional<StateVector> last_change_;  ///< that a whole step would have made
  double stride_ = 1.0;                     ///< share of a step that is gone
  bool near_ = false;                       ///< so near the end that slips can be told
  int failures_ = 0;
};

}  // namespace bearing_calibration::core
