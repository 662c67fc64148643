#include "bearing_calibration/noise/noise_record.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/cancellation.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/noise/noise_levels.h"
#include "bearing_calibration/solve/record_weights.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {
namespace {

double fromLogit(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

}  // namespace

NoiseRecord::NoiseRecord(const std::vector<Observation>& observations, const BatchEstimate& fit,
                         const ErrorPriors& errors) {
  const StateLayout layout{errorsInUse(errors), 1};
  const RecordPath& path = fit.path;
  const double usual_interval_s = usualInterval(observations);
  steps_.reserve(observations.size());
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& observation = observations[i];
    const StateVector at = path.stateAt(layout, i);
    const ExpectedAngle expected = expectAzimuth(layout, at, 0, observation.nearby);
    const double interval_s = i == 0 ? 0.0 : secondsBetween(observations[i - 1], observation);
    steps_.push_back(
        {lineariseMotion(layout, path.errors, path.points[i].lights_in_base, observation.motion,
                         path.points[i].motion_error),
         at, expected.J_angle_state, wrapAngle(observation.azimuth_rad - expected.angle_rad),
         std::sqrt(observation.azimuth_variance_rad2), path.rangeAt(i, observation.light),
         usual_interval_s > 0.0 ? interval_s / usual_interval_s : 1.0, i > 0 || fit.beginning,
         observation.motion.has_unseen, fit.weights[i].slipped, fit.weights[i].use_bearing,
         std::nullopt});
    if (!errors.usesElevations() || !observation.elevation) continue;
    const ExpectedAngle over = expectElevation(layout, at, 0, observation.nearby);
    const ObservationWeight& weight = fit.weights[i];
    steps_.back().elevation = {
        over.J_angle_state, observation.elevation->angle_rad - over.angle_rad,
        weight.elevation_widening * weight.elevation_doubt * observation.elevation->variance_rad2};
  }
  before_ = knownBeforehand(layout, path, kFreePass, errors, fit.known());
}

FilteredRecord NoiseRecord::filter(const NoiseUnknowns& unknowns, bool gives_up_slips,
                                   std::size_t count) const {
  endIfCancelled();
  const double bearing_factor = std::exp(unknowns(kBearingLevel));
  const double wheel_factor = std::exp(unknowns(kWheelLevel));
  const double correlation = fromLogit(unknowns(kLasting));
  const double share = fromLogit(unknowns(kLastingShare));
  const double light_size_m = std::exp(unknowns(kLightSize));
  FilteredRecord filtered{{}, before_};
  filtered.innovations.reserve(count);
  StateEstimate& estimate = filtered.last;
  const int errors = estimate.layout.errors;
  // What lasts of the present bearing's noise, over its standard deviation, and its covariance with
  // the state.
  double noise = 0.0;
  double noise_variance = 1.0;
  StateVector shared = StateVector::Zero(estimate.layout.size());
  // The EKF's update by an angle of which so much is the noise that lasts.
  const auto takeIn = [&](const StateRow& H, double residual_rad, double lasting_stddev_rad,
                          double variance_rad2) {
    const StateVector PHt = estimate.covariance * H.transpose() + lasting_stddev_rad * shared;
    const double noise_PHt = H.dot(shared.transpose()) + lasting_stddev_rad * noise_variance;
    const Innovation innovation{
        residual_rad - lasting_stddev_rad * noise,
        H.dot(PHt.transpose()) + lasting_stddev_rad * noise_PHt + variance_rad2};
    const double pull = innovation.residual / innovation.variance;
    estimate.mean += pull * PHt;
    noise += pull * noise_PHt;
    estimate.covariance.noalias() -= PHt * (PHt / innovation.variance).transpose();
    shared -= noise_PHt / innovation.variance * PHt;
    noise_variance -= noise_PHt * noise_PHt / innovation.variance;
    return innovation;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Step& step = steps_[i];
    if (step.moves) {
      LinearMotion motion = step.motion;
      motion.covariance *= wheelFactor(wheel_factor, step.has_unseen);
      if (step.slipped && gives_up_slips) motion.covariance += slipCovariance();
      propagate(motion, &estimate);
      shared.tail<2>() = (motion.R_end_start * shared.tail<2>()).eval() +
                         motion.J_lights_errors * shared.segment(kMountSize, errors);
    }
    const double kept = std::pow(correlation, step.intervals);
    noise *= kept;
    noise_variance = 1.0 - kept * kept * (1.0 - noise_variance);
    shared *= kept;
    if (!step.use_bearing) continue;
    const double variance_rad2 =
        std::pow(bearing_factor * step.stddev_rad, 2) + std::pow(light_size_m / step.range_m, 2);
    const auto residual = [&](const StateRow& H, double at_path_rad) {
      return at_path_rad - H.dot((estimate.mean - step.path).transpose());
    };
    filtered.innovations.push_back(takeIn(step.H, residual(step.H, step.residual_rad),
                                          std::sqrt(share * variance_rad2),
                                          (1.0 - share) * variance_rad2));
    if (!step.elevation) continue;
    const auto& [H, at_path_rad, elevation_variance_rad2] = *step.elevation;
    takeIn(H, residual(H, at_path_rad), 0.0, elevation_variance_rad2);
  }
  symmetrise(&estimate.covariance);
  return filtered;
}

}  // namespace bearing_calibration::core
