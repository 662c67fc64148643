#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/filter/state.h"
#include "bearing_calibration/judge/calibration_state.h"
#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

/// The running estimate at one moment.
struct EstimateRow {
  Stamp stamp;
  double distance_m = 0.0;
  CalibrationState state = CalibrationState::kInitialising;
  MountEstimate mount;
};

/// The running estimate, often enough to be drawn and never too long to be kept.
class EstimateHistory {
 public:
  static constexpr std::size_t kMostRows = 4000;  ///< more than a plot has pixels

  bool isDue(double distance_m, CalibrationState state) const {
    return rows_.empty() || state != rows_.back().state ||
           distance_m >= rows_.back().distance_m + step_m_;
  }

  /// @param result  that has an estimate
  void add(const CalibrationResult& result) {
    if (rows_.size() == kMostRows) thinOut();
    rows_.push_back(
        {result.stamp, result.distance_travelled_m, result.state, *result.base_from_sensor});
  }

  /// All rows, the last one that of the result.
  std::vector<EstimateRow> take(const CalibrationResult& result) {
    if (result.base_from_sensor && (rows_.empty() || rows_.back().stamp != result.stamp)) {
      add(result);
    }
    return std::move(rows_);
  }

 private:
  /// Every second row goes.
  void thinOut() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows_.size(); i += 2) rows_[kept++] = rows_[i];
    rows_.resize(kept);
    step_m_ *= 2.0;
  }

  std::vector<EstimateRow> rows_;
  double step_m_ = 0.01;
};

}  // namespace bearing_calibration::core
