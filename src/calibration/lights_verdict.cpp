#include "bearing_calibration/calibration/lights_verdict.h"

#include <algorithm>
#include <limits>

namespace bearing_calibration::core {

/// The light whose own calibration speaks while there is no joint one: that of the best known
/// mount.
std::size_t LightsVerdict::leader() const {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const Judgement* judgement = lights_[i].calibration().judgement();
    if (judgement == nullptr || judgement->state == CalibrationState::kInconsistent) continue;
    CalibrationResult result;
    lights_[i].calibration().describe(&result);
    const double size = result.base_from_sensor->covariance.trace();
    if (size >= least) continue;
    least = size;
    best = i;
  }
  return best;
}

/// What stands against the verdict of one light alone.
std::optional<Judgement> LightsVerdict::objection() const {
  if (mount_moved_) return mount_moved_;
  if (joint_.outcome() == JointCalibration::Outcome::kTorn) {
    const std::size_t culprit = joint_.contradicting().front();
    return Judgement{CalibrationState::kInconsistent,
                     "the lights give different mounts (" + nameOf(lights_[culprit], culprit) +
                         " against others): one of them moves, or is a reflection",
                     Fault::kLightsDisagree};
  }
  if (joint_.outcome() == JointCalibration::Outcome::kUnfit) {
    return Judgement{CalibrationState::kConverging,
                     "each light fits by itself, but not all of them together: drive on"};
  }
  return std::nullopt;
}

/// Why a light is not in the estimate.
std::string LightsVerdict::noteOn(std::size_t light) const {
  const std::vector<std::size_t>& contradicting = joint_.contradicting();
  if (std::count(contradicting.begin(), contradicting.end(), light) > 0) {
    return "gives another mount than the others: it moves, or is a reflection";
  }
  return lights_[light].obstacle();
}

/// All lights with what their own calibrations say; `result` is filled by the leading one.
std::vector<LightSummary> LightsVerdict::summarise(std::size_t leading,
                                                   CalibrationResult* result) const {
  std::vector<LightSummary> summaries;
  const CalibrationResult empty = *result;
  std::uint32_t used = 0;
  std::uint32_t gated = 0;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    CalibrationResult own = empty;
    lights_[i].calibration().describe(&own);
    used += own.bearings_used;
    gated += own.bearings_gated;
    summaries.push_back(own.lights.front());
    summaries.back().in_estimate =
        !joint_.joint() && i == leading && own.cartesian_state.has_value();
    if (i == leading) *result = own;
  }
  result->bearings_used = used;
  result->bearings_gated = gated;
  return summaries;
}

/// What all lights together say takes the place of what one says.
void LightsVerdict::takeJoint(CalibrationResult* result) const {
  const auto& joint = joint_.joint();
  if (!joint) return;
  const StateEstimate estimate = joint->filter.estimate();
  for (std::size_t k = 0; k < joint->lights.size(); ++k) {
    LightSummary& summary = result->lights[joint->lights[k]];
    summary.in_estimate = true;
    summary.cartesian_state = estimate.cartesian(static_cast<int>(k));
  }
  // a rival of all of them is at least as far behind as with any one
  const auto gapOf = [this](std::size_t light) { return lights_[light].calibration().rival().gap; };
  const std::size_t surest =
      *std::max_element(joint->lights.begin(), joint->lights.end(),
                        [&](std::size_t a, std::size_t b) { return gapOf(a) < gapOf(b); });
  result->rival = lights_[surest].calibration().rival();
  sayEstimate(estimate, result);
  result->state = joint->judgement.state;
  result->advice = joint->judgement.advice;
  result->cause = joint->judgement.cause;
}

void LightsVerdict::describe(CalibrationResult* result) const {
  result->lights = summarise(leader(), result);
  takeJoint(result);
  for (std::size_t i = 0; i < result->lights.size(); ++i) {
    if (!result->lights[i].in_estimate) result->lights[i].note = noteOn(i);
  }
  const auto against = objection();
  const bool is_verdict = result->state == CalibrationState::kConverged ||
                          result->state == CalibrationState::kConverging;
  if (against && is_verdict) {
    result->state = against->state;
    result->advice = against->advice;
    result->cause = against->cause;
  }
}

}  // namespace bearing_calibration::core
