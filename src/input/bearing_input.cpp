#include "bearing_calibration/input/bearing_input.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

/// Whether a candidate is a bearing at all.
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
  const double of_track =
      std::isnan(candidate.track_probability) ? 0.0 : candidate.track_probability;
  for (const double probability : {candidate.probability, of_track}) {
    if (!(probability >= 0.0 && probability <= 1.0)) {
      return {InputStatus::kProbabilityOutOfRange, probability};
    }
  }
  return {};
}

/// The same of an elevation: what is none leaves an azimuth to be used.
void checkElevation(Bearing* candidate, std::vector<InputOutcome>* remarks) {
  constexpr double kMost_rad = 0.5 * kPi + 0.1;  // that of a light overhead, with its noise
  if (!elevationOf(*candidate) || std::abs(candidate->elevation_rad) <= kMost_rad) return;
  remarks->push_back({InputStatus::kElevationLeftOut, candidate->elevation_rad});
  candidate->elevation_rad = candidate->elevation_variance_rad2 = Bearing().elevation_rad;
}

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

InputOutcome checkGeometry(const SensorGeometry& geometry) {
  constexpr double kMost = 1.0;  // rad, m, rad m: far beyond any mirror that shows a light
  for (const double value : {geometry.harmonic_stddev_rad, geometry.nearness_stddev_rad_m,
                             std::abs(geometry.near_per_far_m)}) {
    if (!(value >= 0.0 && value <= kMost)) return {InputStatus::kGeometryAbsurd, value};
  }
  return {};
}

InputOutcome checkView(const FieldOfView& view) {
  if (view.isPossible()) return {};
  const bool is_centre_possible = FieldOfView{view.centre_rad, 0.0}.isPossible();
  return {InputStatus::kViewImpossible, is_centre_possible ? view.width_rad : view.centre_rad};
}

CheckedBearings checkBearings(const BearingSet& bearings, const BearingInputConfig& config) {
  const double unmodelled_rad = bearings.geometry.unmodelledStddev();
  CheckedBearings checked;
  checked.bearings.stamp = bearings.stamp - durationFromSeconds(config.latency_s);
  checked.bearings.view = bearings.view;
  checked.bearings.candidates.reserve(bearings.candidates.size());
  for (Bearing candidate : bearings.candidates) {
    const InputOutcome outcome = checkCandidate(candidate, config);
    if (!outcome.accepted()) {
      checked.remarks.push_back(outcome);
      continue;
    }
    const double probability = candidate.overallProbability();
    if (probability < config.min_probability) {
      if (probability == 0.0)
        checked.remarks.push_back({InputStatus::kProbabilityZero, probability});
      continue;
    }
    checkElevation(&candidate, &checked.remarks);
    const double least_rad2 = config.min_stddev_rad * config.min_stddev_rad;
    raiseVariance(least_rad2, &candidate.azimuth_variance_rad2, &checked.remarks);
    raiseVariance(least_rad2, &candidate.elevation_variance_rad2, &checked.remarks);
    candidate.azimuth_variance_rad2 +=
        config.extra_stddev_rad * config.extra_stddev_rad + unmodelled_rad * unmodelled_rad;
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

void BearingInputConfig::declare(Parameters& params) {
  using namespace plausible;
  constexpr double kLongestLatency_s = 10.0;
  constexpr double kLongestWait_s = 60.0;
  constexpr int kMostWaiting = 100000;  // messages: some 10 MB
  params.number("bearings/latency", latency_s, -kLongestLatency_s, kLongestLatency_s);
  params.number("bearings/extra_stddev", extra_stddev_rad, 0.0, kPi);
  params.number("bearings/min_stddev", min_stddev_rad, kLeastAngle_rad, kPi);
  params.number("bearings/max_stddev", max_stddev_rad, kLeastAngle_rad, kPi);
  params.that(max_stddev_rad > min_stddev_rad,
              "bearings/max_stddev must be greater than bearings/min_stddev");
  params.number("bearings/max_future", max_future_s, 0.0, kLongest_s);
  params.number("bearings/reorder_window", reorder_window_s, 0.0, kLongestWait_s);
  params.integer("bearings/max_waiting", max_waiting, 1, kMostWaiting);
  params.number("bearings/min_probability", min_probability, 0.0, 1.0);
}

}  // namespace bearing_calibration::core
