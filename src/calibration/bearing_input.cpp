#include "bearing_calibration/calibration/bearing_input.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

/// A stated variance below `least` becomes that. NaN, zero and less say that there is none.
void raiseVariance(double least, double* variance, std::vector<InputOutcome>* remarks) {
  if (!(*variance > 0.0 && *variance < least)) return;
  remarks->push_back({InputStatus::kVarianceRaised, *variance});
  *variance = least;
}

}  // namespace

InputOutcome checkStamp(Stamp stamp, Stamp received, double max_future_s) {
  if (!isStamped(stamp)) return {InputStatus::kNoStamp, 0.0};
  const double ahead_s = secondsFromDuration(stamp - received);
  if (ahead_s > max_future_s) return {InputStatus::kStampInFuture, ahead_s};
  return {};
}

InputOutcome checkCandidate(const Bearing& candidate, const BearingInputConfig& config) {
  constexpr double kTurn_rad = 2.0 * kPi * (1.0 + 1e-6);  // 2 pi as a float is a little more
  const double variance = candidate.azimuth_variance_rad2;
  if (!std::isfinite(candidate.azimuth_rad)) {
    return {InputStatus::kAzimuthNotFinite, candidate.azimuth_rad};
  }
  if (std::abs(candidate.azimuth_rad) > kTurn_rad) {
    return {InputStatus::kAzimuthBeyondATurn, candidate.azimuth_rad};
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
      checked.remarks.push_back(outcome);
      continue;
    }
    if (candidate.quality < config.min_quality) continue;
    const double least_rad2 = config.min_stddev_rad * config.min_stddev_rad;
    raiseVariance(least_rad2, &candidate.azimuth_variance_rad2, &checked.remarks);
    raiseVariance(least_rad2, &candidate.elevation_variance_rad2, &checked.remarks);
    candidate.azimuth_variance_rad2 += config.extra_stddev_rad * config.extra_stddev_rad;
    checked.bearings.candidates.push_back(candidate);
  }
  return checked;
}

std::string adviceWithSensor(const InputCounts& bearing_inputs, std::uint32_t bearings_used,
                             const std::string& advice) {
  constexpr std::uint32_t kRare = 100;  // one of so many is a glitch
  const std::uint32_t beyond = bearing_inputs[InputStatus::kAzimuthBeyondATurn];
  if (beyond > bearings_used / kRare) {
    return std::to_string(beyond) +
           " azimuths lie beyond 2 pi: is the sensor in degrees? bearings are in radians";
  }
  const std::uint32_t raised = bearing_inputs[InputStatus::kVarianceRaised];
  if (raised > bearings_used / kRare) {
    return std::to_string(raised) +
           " variances are stated below that of bearings/min_stddev: state the spread that is seen "
           "while the robot stands; " +
           advice;
  }
  return advice;
}

}  // namespace bearing_calibration
