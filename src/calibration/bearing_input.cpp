#include "bearing_calibration/calibration/bearing_input.h"

#include <cmath>

namespace bearing_calibration {

InputOutcome checkStamp(Stamp stamp, Stamp received, double max_future_s) {
  if (!isStamped(stamp)) return {InputStatus::kNoStamp, 0.0};
  const double ahead_s = secondsFromDuration(stamp - received);
  if (ahead_s > max_future_s) return {InputStatus::kStampInFuture, ahead_s};
  return {};
}

InputOutcome checkCandidate(const Bearing& candidate, const BearingInputConfig& config) {
  const double variance = candidate.azimuth_variance_rad2;
  if (!std::isfinite(candidate.azimuth_rad)) {
    return {InputStatus::kAzimuthNotFinite, candidate.azimuth_rad};
  }
  if (!(std::isfinite(variance) && variance > 0.0)) {
    return {InputStatus::kVarianceNotPositive, variance};
  }
  if (variance > config.max_stddev_rad * config.max_stddev_rad) {
    return {InputStatus::kVarianceAbsurd, variance};
  }
  if (!(candidate.quality >= 0.0 && candidate.quality <= 1.0)) {
    return {InputStatus::kQualityOutOfRange, candidate.quality};
  }
  return {};
}

CheckedBearings checkBearings(const BearingSet& bearings, const BearingInputConfig& config) {
  CheckedBearings checked;
  checked.bearings.stamp = bearings.stamp - durationFromSeconds(config.latency_s);
  checked.bearings.candidates.reserve(bearings.candidates.size());
  for (Bearing candidate : bearings.candidates) {
    const InputOutcome outcome = checkCandidate(candidate, config);
    if (!outcome.accepted()) {
      checked.refused.push_back(outcome);
      continue;
    }
    if (candidate.quality < config.min_quality) continue;
    candidate.azimuth_variance_rad2 += config.extra_stddev_rad * config.extra_stddev_rad;
    checked.bearings.candidates.push_back(candidate);
  }
  return checked;
}

}  // namespace bearing_calibration
