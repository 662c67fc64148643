#include "bearing_calibration/calibration/several_lights.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace bearing_calibration::core {
namespace {

/// A light that has not been found out and not been seen for so long makes room for another.
constexpr std::chrono::seconds kForgottenAfter{30};
/// After so much way a light that alone says that the mount has moved has moved itself: what a
/// displacement of 3 degrees takes the others to notice (doc/faults.md).
constexpr double kAloneFor_m = 10.0;

bool isSame(const Bearing& bearing, const Observation& observation) {
  return bearing.azimuth_rad == observation.azimuth_rad &&
         bearing.azimuth_variance_rad2 == observation.azimuth_variance_rad2;
}

void take(const Judgement& judgement, CalibrationResult* result) {
  result->state = judgement.state;
  result->advice = judgement.advice;
  result->cause = judgement.cause;
}

}  // namespace

SeveralLights::SeveralLights(const CalibratorConfig& config, FitsRun fits_run)
    : config_(config), fits_run_(fits_run), joint_(config) {
  lights_.reserve(kMostLights);
  if (!isMany()) lights_.emplace_back(config_, fits_run_);
}

void SeveralLights::resume(const StateEstimate& earlier) {
  earlier_ = earlier;
  for (MountCalibration& light : lights_) light.resume(earlier);
}

AssociationOutcome SeveralLights::process(const BearingSet& image, const OdometryIncrement& motion,
                                          const OdometryWindow& nearby) {
  if (!isMany()) {
    const AssociationOutcome outcome = lights_.front().process(image, motion, nearby);
    if (outcome.lost_light) ++new_starts_;
    return outcome;
  }
  std::vector<Bearing> left = image.candidates;
  LightsImage seen{image.stamp, motion, nearby, {}};
  AssociationOutcome first = AssociationOutcome::of(image.stamp, motion, nearby);
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const AssociationOutcome outcome = show(i, image, &left, &seen);
    if (i == 0) first = outcome;
  }
  const bool is_empty = lights_.empty();
  welcome(image, &left, &seen);
  if (is_empty && !lights_.empty() && seen.lights[0].isSeen()) {
    first.kind = AssociationOutcome::Kind::kTaken;
    first.observation.azimuth_rad = seen.lights[0].azimuth_rad;
    first.observation.azimuth_variance_rad2 = seen.lights[0].azimuth_variance_rad2;
  }
  joint_.add(seen);
  if (fits_run_ == FitsRun::kAtOnce) work();
  return first;
}

/// Each light for itself: what concerns all of them is decided here.
MountCalibration SeveralLights::newLight() const {
  CalibratorConfig config = config_;
  config.restart_on_mount_change = false;
  MountCalibration light(config, fits_run_);
  if (earlier_) light.resume(*earlier_);
  return light;
}

bool SeveralLights::isWorkDue() const {
  return joint_.isReviewDue() ||
         std::any_of(lights_.begin(), lights_.end(),
                     [](const MountCalibration& light) { return light.isWorkDue(); });
}

void SeveralLights::work() {
  for (MountCalibration& light : lights_) {
    if (light.isWorkDue()) light.work();
  }
  if (joint_.isReviewDue()) review();
}

bool SeveralLights::isOwned(std::int32_t light_id) const {
  return std::any_of(lights_.begin(), lights_.end(),
                     [&](const MountCalibration& light) { return light.lightId() == light_id; });
}

bool SeveralLights::isOffered(const Bearing& candidate, const MountCalibration& light) const {
  const std::int32_t own_id = light.lightId();
  if (candidate.light_id == kUnknownLight || candidate.light_id == own_id) return true;
  return own_id == kUnknownLight && !isOwned(candidate.light_id);
}

/// Shows a light what the lights before it have left of an image, and takes away what it takes.
AssociationOutcome SeveralLights::show(std::size_t light, const BearingSet& image,
                                       std::vector<Bearing>* left, LightsImage* seen) {
  BearingSet offered{image.stamp, {}};
  std::copy_if(left->begin(), left->end(), std::back_inserter(offered.candidates),
               [&](const Bearing& candidate) { return isOffered(candidate, lights_[light]); });
  const AssociationOutcome outcome = lights_[light].process(offered, seen->motion, seen->nearby);
  if (outcome.lost_light) {
    joint_.forget(light);
    ++new_starts_;
  }
  if (outcome.kind != AssociationOutcome::Kind::kTaken) return outcome;
  seen->lights.at(light) = {outcome.observation.azimuth_rad,
                            outcome.observation.azimuth_variance_rad2};
  const auto taken = std::find_if(left->begin(), left->end(), [&](const Bearing& candidate) {
    return isSame(candidate, outcome.observation);
  });
  if (taken != left->end()) left->erase(taken);
  return outcome;
}

/// What no light has taken may be a further one.
void SeveralLights::welcome(const BearingSet& image, std::vector<Bearing>* left,
                            LightsImage* seen) {
  const bool has_newcomer =
      std::any_of(lights_.begin(), lights_.end(), [](const MountCalibration& light) {
        return light.lightId() == kUnknownLight && !light.isFound();
      });
  bool may_be_unknown = !has_newcomer;
  for (;;) {
    const auto newcomer = std::find_if(left->begin(), left->end(), [&](const Bearing& candidate) {
      return candidate.light_id == kUnknownLight ? may_be_unknown : !isOwned(candidate.light_id);
    });
    const auto place = placeForAnother(image.stamp);
    if (newcomer == left->end() || !place) return;
    if (newcomer->light_id == kUnknownLight) may_be_unknown = false;
    if (*place == lights_.size()) {
      lights_.push_back(newLight());
    } else {
      lights_[*place] = newLight();
      joint_.forget(*place);
    }
    std::vector<Bearing> own = {*newcomer};
    show(*place, image, &own, seen);
    left->erase(newcomer);
  }
}

std::optional<std::size_t> SeveralLights::placeForAnother(Stamp now) const {
  if (lights_.size() < static_cast<std::size_t>(config_.max_lights)) return lights_.size();
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const MountCalibration& light = lights_[i];
    if (!light.isFound() && light.lastSeen() + kForgottenAfter < now) return i;
  }
  return std::nullopt;
}

void SeveralLights::review() {
  mount_moved_ = agreeOnMountMoved();
  if (mount_moved_ && mount_moved_->cause == Fault::kMountMoved &&
      config_.restart_on_mount_change) {
    startAnew();
    return;
  }
  std::vector<const LandmarkSolution*> answers;
  LightPositions lights_in_base(2, lights_.size());
  bool is_earlier_believed = earlier_.has_value();
  for (const MountCalibration& light : lights_) {
    answers.push_back(light.isSound() ? &*light.solution() : nullptr);
    if (light.isSound()) {
      lights_in_base.col(static_cast<Eigen::Index>(answers.size()) - 1) = light.lightInBase();
    }
    if (light.isSound() && !light.earlier()) is_earlier_believed = false;
  }
  joint_.review(answers, lights_in_base, is_earlier_believed ? earlier_ : std::nullopt);
  for (MountCalibration& light : lights_) light.shareSince(joint_.since());
}

/// A mount that has moved is noticed by all lights, though not at once; a light that was moved says
/// the same, but alone.
std::optional<Judgement> SeveralLights::agreeOnMountMoved() const {
  const auto found = std::count_if(lights_.begin(), lights_.end(),
                                   [](const MountCalibration& light) { return light.isFound(); });
  std::ptrdiff_t moved = 0;
  std::optional<Judgement> alone;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const std::optional<double> moved_for_m = lights_[i].movedFor();
    if (!moved_for_m) continue;
    if (2 * ++moved >= found) return *lights_[i].judgement();
    if (*moved_for_m < kAloneFor_m) {
      alone = {CalibrationState::kConverging,
               nameOf(i) + " reports that the mount has moved, the others do not: drive on"};
    }
  }
  return alone;
}

void SeveralLights::startAnew() {
  lights_.clear();
  earlier_.reset();
  joint_ = JointCalibration(config_);
  mount_moved_.reset();
  restarted_ = true;
}

/// "light 7", or "light number 1" of one whose own number nobody knows.
std::string SeveralLights::nameOf(std::size_t light) const {
  const std::int32_t id = lights_[light].lightId();
  return id == kUnknownLight ? "light number " + std::to_string(light + 1)
                             : "light " + std::to_string(id);
}

/// What stands against the verdict of one light alone.
std::optional<Judgement> SeveralLights::objection() const {
  if (mount_moved_) return mount_moved_;
  if (joint_.outcome() == JointCalibration::Outcome::kTorn) {
    return Judgement{CalibrationState::kInconsistent,
                     "the lights give different mounts (" + nameOf(joint_.contradicting().front()) +
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
std::string SeveralLights::noteOn(std::size_t light) const {
  const std::vector<std::size_t>& contradicting = joint_.contradicting();
  if (std::count(contradicting.begin(), contradicting.end(), light) > 0) {
    return "gives another mount than the others: it moves, or is a reflection";
  }
  return lights_[light].obstacle();
}

/// All lights with what their own calibrations say. While there is no joint one, the one speaks
/// whose mount is known best.
void SeveralLights::summarise(CalibrationResult* result) const {
  const CalibrationResult empty = *result;
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
    const bool may_speak =
        lights_[i].isFound() && lights_[i].judgement()->state != CalibrationState::kInconsistent;
    const double size = may_speak ? own.base_from_sensor->covariance.trace() : least;
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
  take(joint->judgement, result);
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
  const auto against = objection();
  const bool is_verdict = result->state == CalibrationState::kConverged ||
                          result->state == CalibrationState::kConverging;
  if (against && is_verdict) take(*against, result);
  if (restarted_) sayRestarted(result);
}

std::optional<AzimuthPrediction> SeveralLights::predictAzimuthAfter(
    const OdometryIncrement& motion, const OdometryWindow& nearby) const {
  if (isMany()) return std::nullopt;
  return lights_.front().predictAzimuthAfter(motion, nearby);
}

std::int32_t SeveralLights::lightId() const {
  return isMany() ? kUnknownLight : lights_.front().lightId();
}

}  // namespace bearing_calibration::core
