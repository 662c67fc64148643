#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "bearing_calibration/calibration/several_lights.h"

namespace bearing_calibration::core {
namespace {

void say(const Judgement& judgement, CalibrationResult* result) {
  result->state = judgement.state;
  result->advice = judgement.advice;
  result->cause = judgement.cause;
}

void say(const Consistency& consistency, CalibrationResult* result) {
  result->nis = consistency.nis;
  result->nis_mean = consistency.nis_mean;
}

}  // namespace

void MountCalibration::describe(CalibrationResult* result) const {
  result->error_priors = config_.initializer.batch.errors;
  result->robot_errors = priorEstimate(config_.initializer.batch.errors);
  result->noise_priors = config_.initializer.noise;
  result->noise = noise_;
  result->correlation_time = correlation_time_;
  result->rival = rival_;
  result->bearings_used = bearings_used_;
  result->bearings_gated = bearings_gated_;
  std::optional<CartesianEstimate> own;
  if (const std::optional<MountTracker>& known = tracker_ ? tracker_ : search_.weak(); known) {
    const StateEstimate estimate = known->filter().estimate();
    sayEstimate(estimate, result);
    if (config_.filter.parametrisation == FilterConfig::Parametrisation::kPaper) {
      result->paper_state = known->filter().paper();
    }
    own = estimate.cartesian();
    say(known->consistency(), result);
  }
  if (started_) {
    say(judge_->last(), result);
    if (isRefuted()) result->state = CalibrationState::kInconsistent;
  } else {
    search_.describe(result);
  }
  result->lights = {{lightId(), result->state, own, true, bearings_used_, ""}};
  if (result->state == CalibrationState::kInconsistent && diagnosis_.fault != Fault::kNone &&
      diagnosis_.fault != result->cause) {
    result->advice = ::bearing_calibration::core::describe(diagnosis_);
    result->cause = diagnosis_.fault;
  }
  if (restarted_) sayRestarted(result);
}

std::string MountCalibration::obstacle() const {
  if (!isFound()) return "not found yet";
  const Judgement& judgement = judge_->last();
  if (isRefuted()) return ::bearing_calibration::core::describe(diagnosis_);
  if (judgement.state == CalibrationState::kInconsistent) return judgement.advice;
  return is_sound_ ? "" : "not yet confirmed";
}

/// "light 7", or "light number 1" of one whose own number nobody knows.
std::string SeveralLights::nameOf(std::size_t light) const {
  const std::int32_t id = lights_[light].lightId();
  return id == kUnknownLight ? "light number " + std::to_string(light + 1)
                             : "light " + std::to_string(id);
}

/// Whether one of the lights in view is in the estimate, if any is in view: the others would not
/// notice that the mount is displaced.
bool SeveralLights::isOfLightsInView(const CalibrationResult& result) const {
  bool is_any_in_view = false;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (lights_[i].unseenFor_m() > kNoticedWithin_m) continue;
    if (result.lights[i].in_estimate) return true;
    is_any_in_view = true;
  }
  return !is_any_in_view;
}

/// What stands against the verdict of those lights that give the estimate.
std::optional<Judgement> SeveralLights::objectionTo(const CalibrationResult& result) const {
  if (mount_moved_) return mount_moved_;
  if (joint_.outcome() == JointCalibration::Outcome::kTorn) {
    return Judgement{CalibrationState::kInconsistent,
                     "the lights give different mounts (" + nameOf(joint_.contradicting().front()) +
                         " against others): one of them moves or is a reflection, or the mount "
                         "was moved while some were out of view: call ~reset to calibrate anew",
                     Fault::kLightsDisagree};
  }
  if (joint_.outcome() == JointCalibration::Outcome::kUnfit) {
    return Judgement{CalibrationState::kConverging,
                     "each light fits by itself, but not all of them together: drive on"};
  }
  if (!isOfLightsInView(result)) {
    return Judgement{CalibrationState::kConverging,
                     "the lights that gave the mount are out of view, and those in view do not "
                     "confirm it yet: drive on near any of them, or call ~reset if the mount was "
                     "moved"};
  }
  return std::nullopt;
}

/// Whether the last review has left it out.
bool SeveralLights::isContradicting(std::size_t light) const {
  const std::vector<std::size_t>& all = joint_.contradicting();
  return std::count(all.begin(), all.end(), light) > 0;
}

/// Why a light is not in the estimate.
std::string SeveralLights::noteOn(std::size_t light) const {
  if (isContradicting(light)) {
    return "gives another mount than the others: it moves, or is a reflection";
  }
  return lights_[light].obstacle();
}

/// All lights with what their own calibrations say. While there is no joint one, the one speaks
/// whose mount is known best; one that is not confirmed only where none is.
void SeveralLights::summarise(CalibrationResult* result) const {
  const CalibrationResult empty = *result;
  bool any_sound = false;
  for (std::size_t i = 0; i < lights_.size(); ++i)
    any_sound = any_sound || (lights_[i].isSound() && !isContradicting(i));
  std::vector<LightSummary> summaries;
  std::size_t leader = 0;
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t used = 0;
  std::uint32_t gated = 0;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    CalibrationResult own = empty;
    lights_[i].describe(&own);
    used += own.bearings_used;
    gated += own.bearings_gated;
    summaries.push_back(own.lights.front());
    summaries.back().in_estimate = false;
    const bool may_speak = lights_[i].isFound() && (lights_[i].isSound() || !any_sound) &&
                           own.state != CalibrationState::kInconsistent && !isContradicting(i);
    const double size = may_speak ? own.base_from_sensor->covariance.determinant() : least;
    if (i > 0 && !(size < least)) continue;
    least = may_speak ? size : least;
    leader = i;
    *result = own;
  }
  if (!summaries.empty()) {
    summaries[leader].in_estimate = !joint_.joint() && result->cartesian_state.has_value();
  }
  result->lights = summaries;
  result->bearings_used = used;
  result->bearings_gated = gated;
}

/// What all lights together say takes the place of what one says.
void SeveralLights::takeJoint(CalibrationResult* result) const {
  const auto& joint = joint_.joint();
  if (!joint) return;
  const StateEstimate estimate = joint->filter.estimate();
  result->rival = lights_[joint->lights.front()].rival();
  for (std::size_t k = 0; k < joint->lights.size(); ++k) {
    LightSummary& summary = result->lights[joint->lights[k]];
    summary.in_estimate = true;
    summary.cartesian_state = estimate.cartesian(static_cast<int>(k));
    // a rival of all of them is at least as far behind as with any one
    const RivalMount& rival = lights_[joint->lights[k]].rival();
    if (rival.gap > result->rival.gap) result->rival = rival;
  }
  sayEstimate(estimate, result);
  say(joint->recent.consistency(), result);
  say(joint->judgement, result);
}

void SeveralLights::describe(CalibrationResult* result) const {
  if (!isMany()) return lights_.front().describe(result);
  result->error_priors = config_.initializer.batch.errors;
  result->robot_errors = priorEstimate(result->error_priors);
  summarise(result);
  takeJoint(result);
  for (std::size_t i = 0; i < result->lights.size(); ++i) {
    if (!result->lights[i].in_estimate) result->lights[i].note = noteOn(i);
  }
  const auto against = objectionTo(*result);
  if (against && mayBeTrusted(result->state)) say(*against, result);
  if (is_ambiguous_ && result->state == CalibrationState::kWaitingForLight) {
    result->advice =
        "the lights are seen too close to each other to be distinguished: drive to where they "
        "are apart, or cover all but one";
  }
  if (restarted_) sayRestarted(result);
}

}  // namespace bearing_calibration::core
