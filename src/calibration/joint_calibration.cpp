#include "bearing_calibration/calibration/joint_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/init/start_obstacle.h"
#include "bearing_calibration/judge/lights_agreement.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "bearing_calibration/solve/mount_displacement.h"

namespace bearing_calibration::core {
namespace {

/// Largest NIS of a bearing, five standard deviations. A light's own filter, which knows less, may
/// have taken another light for it, or follow it after a slip: the next fit tells.
constexpr double kGate = 25.0;

constexpr std::size_t kNoLight = std::numeric_limits<std::size_t>::max();

/// Slips and outliers of each light have been decided by its own fit: what fits worse together is
/// no slip, but one light too many.
BatchConfig withoutSlips(BatchConfig config) {
  config.huber_sigmas = 0.0;
  config.slip_gain = 0.0;
  return config;
}

/// What the suppositions about slips in one light's record differ by (see averageOverSlips).
Eigen::Matrix3d spreadOf(const LandmarkSolution& answer) {
  const MountEstimate average = answer.average.mount();
  const MountEstimate best = answer.fit.last.mount();
  const Eigen::Vector3d shift = mountDifference(average.mean, best.mean);
  return average.covariance - best.covariance + shift * shift.transpose();
}

/// A slip that one light suspects and another does not is none: the least spread stays in the
/// mount's covariance.
void addSpread(const std::vector<const LandmarkSolution*>& answers, StateEstimate* estimate) {
  std::vector<Eigen::Matrix3d> spreads;
  spreads.reserve(answers.size());
  for (const LandmarkSolution* answer : answers) spreads.push_back(spreadOf(*answer));
  const Eigen::Matrix3d covariance = estimate->mount().covariance;
  estimate->covariance.topLeftCorner<3, 3>() += leastSpread(spreads, covariance);
}

}  // namespace

JointCalibration::JointCalibration(const CalibratorConfig& config)
    : config_(config), record_(config.initializer.record) {}

void JointCalibration::add(const LightsImage& image) {
  motion_since_record_ = append(motion_since_record_, image.motion);
  const bool shows_any =
      std::any_of(image.lights.begin(), image.lights.end(),
                  [](const LightObservation& observation) { return observation.isSeen(); });
  if (shows_any) {
    LightsImage kept = image;
    kept.motion = motion_since_record_;
    record_.add(kept);
    motion_since_record_ = {};
  }
  is_review_due_ = shows_any && reviews_.isDue(record_);
  if (!joint_) return;
  if (image.motion.isTurnUnknown()) {
    joint_.reset();
    return;
  }
  joint_->filter.predict(withNoise(image.motion, wheel_noise_));
  for (std::size_t i = 0; i < joint_->lights.size(); ++i) {
    const LightObservation& observation = image.lights.at(joint_->lights[i]);
    if (!observation.isSeen()) continue;
    Bearing bearing;
    bearing.azimuth_rad = observation.azimuth_rad;
    bearing.azimuth_variance_rad2 = observation.azimuth_variance_rad2;
    if (observation.elevation) {
      bearing.elevation_rad = observation.elevation->angle_rad;
      bearing.elevation_variance_rad2 = observation.elevation->variance_rad2;
    }
    const auto light = static_cast<int>(i);
    const AzimuthPrediction expected = joint_->filter.predictAzimuth(image.nearby, light);
    bearing = withNoise(bearing, noise_[i], expected.range_m);
    const Innovation innovation =
        expected.innovationOf(bearing.azimuth_rad, bearing.azimuth_variance_rad2);
    if (innovation.nis() > kGate) {
      joint_->recent.noteNotFused();
      continue;
    }
    joint_->recent.noteFused(innovation.nis());
    joint_->filter.update(bearing, image.nearby, light);
  }
  joint_->judgement.doubt(joint_->recent.consistency());
}

void JointCalibration::forget(std::size_t light) {
  record_.forget(light);
  std::replace(lights_given_away_.begin(), lights_given_away_.end(), light, kNoLight);
  if (joint_ && std::count(joint_->lights.begin(), joint_->lights.end(), light) > 0) {
    joint_.reset();
  }
  contradicting_.erase(std::remove(contradicting_.begin(), contradicting_.end(), light),
                       contradicting_.end());  // the next one there is another
  if (outcome_ == Outcome::kTorn && contradicting_.empty()) outcome_ = Outcome::kTooFew;
}

void JointCalibration::review(const std::vector<const LandmarkSolution*>& answers,
                              const LightPositions& lights_in_base,
                              const std::optional<StateEstimate>& earlier) {
  is_review_due_ = false;
  lights_in_base_ = lights_in_base;
  reviews_.begin(record_, fitPace(config_.refit_growth));
  std::vector<std::size_t> lights;
  std::vector<MountEstimate> mounts;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] == nullptr || !isInRecord(i)) continue;
    lights.push_back(i);
    mounts.push_back(answers[i]->average.mount());
  }
  const LightsAgreement agreement = compareLights(mounts);
  contradicting_.clear();
  for (std::size_t i : agreement.contradicting) contradicting_.push_back(lights[i]);
  std::vector<std::size_t> agreeing;
  for (std::size_t i : agreement.agreeing) agreeing.push_back(lights[i]);

  joint_.reset();
  outcome_ = Outcome::kTooFew;
  while (outcome_ != Outcome::kJoint) {
    if (!contradicting_.empty() && agreeing.size() <= contradicting_.size()) {
      outcome_ = Outcome::kTorn;
      return;
    }
    if (agreeing.size() < 2) return;
    outcome_ = fitTogether(answers, agreeing);
    if (outcome_ == Outcome::kTooFew) return;
    if (outcome_ == Outcome::kJoint) continue;
    const auto culprit = outcome_ == Outcome::kTorn ? std::optional(mostContradicted(answers))
                                                    : oneTooMany(answers, agreeing);
    joint_.reset();
    if (!culprit) return;
    contradicting_.push_back(*culprit);
    agreeing.erase(std::find(agreeing.begin(), agreeing.end(), *culprit));
  }
  // One that is wrong pulls the joint answer about as far from the truth as it is from it. A sound
  // one may be doubted for a moment; one that moves slowly is, long before it is found out.
  constexpr double kFalseDoubt = 0.01;
  const double most = contradictionOf(*answers[mostContradicted(answers)]);
  const bool is_clear = most <= largestContradiction(agreeing.size(), kFalseDoubt);
  StateEstimate estimate = joint_->filter.estimate();
  if (earlier) addEarlier(*earlier, config_.initializer.batch.errors, &estimate);
  estimate = withDoubtOfLengths(estimate, config_.initializer.batch.errors);
  joint_->filter.restart(estimate);
  joint_->judgement = judge(estimate, is_clear);
  if (!is_clear || !oldest_) return;
  record_.cut(*oldest_);
  lights_given_away_ = joint_->lights;
}

/// Seen in one of its images, or known by what it has given away.
bool JointCalibration::isInRecord(std::size_t light) const {
  const std::vector<LightsImage>& images = record_.entries();
  return std::count(lights_given_away_.begin(), lights_given_away_.end(), light) > 0 ||
         std::any_of(images.begin(), images.end(),
                     [light](const LightsImage& image) { return image.lights.at(light).isSeen(); });
}

/// What was given away, of these lights.
std::optional<RecordBeginning> JointCalibration::beginningOf(
    const std::vector<std::size_t>& lights) const {
  std::optional<RecordBeginning> beginning = record_.beginning();
  if (!beginning) return beginning;
  std::vector<std::optional<int>> places;
  for (std::size_t light : lights) {
    const auto known = std::find(lights_given_away_.begin(), lights_given_away_.end(), light);
    places.push_back(known == lights_given_away_.end()
                         ? std::nullopt
                         : std::optional(static_cast<int>(known - lights_given_away_.begin())));
  }
  const ErrorPriors& errors = config_.initializer.batch.errors;
  const auto count = static_cast<int>(lights.size());
  beginning->known = partOf(beginning->known, errorsInUse(errors, count), places);
  if (!errors.usesElevations()) return beginning;
  for (int i = 0; i < count; ++i) {
    if (places[static_cast<std::size_t>(i)]) continue;
    const int at = kMountSize + heightAt(i);
    beginning->known.mean(at) = errors.mean(heightAt(i));
    beginning->known.covariance(at, at) = std::pow(errors.stddev(heightAt(i)), 2);
  }
  return beginning;
}

/// Of a record that is nearly full, up to an image that shows one of its lights, and not within a
/// slip.
std::optional<RecordPart> JointCalibration::oldestPart(const std::vector<Observation>& observations,
                                                       const BatchEstimate& fit,
                                                       std::size_t lights) const {
  const std::size_t surplus = record_.surplus();
  if (surplus == 0) return std::nullopt;
  const std::vector<LightsImage>& images = record_.entries();
  const auto isWithinSlip = [&](std::size_t end) {
    const auto weight = fit.weights.begin() + static_cast<std::ptrdiff_t>(end);
    return std::any_of(weight - static_cast<std::ptrdiff_t>(std::min(end, lights)), weight + 1,
                       [](const ObservationWeight& each) { return each.slipped; });
  };
  std::size_t end = 0;  // of the observations that are given away
  for (std::size_t i = 1; i < observations.size(); ++i) {
    if (observations[i].stamp > images[surplus].stamp) break;
    if (beginsImage(observations, i) && !isWithinSlip(i)) end = i;
  }
  if (end == 0) return std::nullopt;
  RecordPart part;
  part.known =
      BatchEstimator(withoutSlips(config_.initializer.batch)).knownAt(end - 1, observations, fit);
  part.scatter = scatterOf(fit.mount_displacements, 0, end);
  while (images[part.count].stamp <= observations[end - 1].stamp) ++part.count;
  return part;
}

/// @returns kJoint when they agree, kTorn when one of them does not, kUnfit, kTooFew when none of
///   them is seen in the record
JointCalibration::Outcome JointCalibration::fitTogether(
    const std::vector<const LandmarkSolution*>& answers, const std::vector<std::size_t>& lights) {
  constexpr double kFalseAlarm = 1e-4;
  std::vector<const LandmarkSolution*> taken;
  noise_.clear();
  for (std::size_t light : lights) {
    const LandmarkSolution& own = *answers[light];
    taken.push_back(&own);
    noise_.push_back(own.noise.widenedFor(own.fit.correlation));
  }
  wheel_noise_.wheel = surestOf(taken).noise.wheel;
  const std::vector<Observation> observations =
      withNoise(observationsOf(record_.entries(), lights), taken);
  if (observations.empty()) return Outcome::kTooFew;
  const auto since = withNoise(motionAfter(observations, record_.entries()), wheel_noise_);
  RecordStart start(surestOf(taken).fit.last, observations.size() - 1);
  start.lights_in_base = lights_in_base_(Eigen::all, lights);
  for (auto light : start.lights_in_base.colwise()) light = since.start_from_end * light;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    start.errors(heightAt(static_cast<int>(i))) = taken[i]->fit.path.errors(heightAt(0));
  }
  RecordTrack track = trackLights(observations, start);
  setOutliersAside(observations, taken, &track);
  SlipHypothesis slips;
  slips.given_up = slipsOf(observations, taken);
  const BatchEstimate fit = BatchEstimator(withoutSlips(config_.initializer.batch))
                                .estimate(observations, track, slips, beginningOf(lights));
  if (!fitsWell(fit, config_.initializer)) return Outcome::kUnfit;
  StateEstimate estimate = widened(fit.last, fit.scatter().widening());
  addSpread(taken, &estimate);
  joint_ = Joint{LiveFilter(estimate), lights, Judgement(), RecentInnovations()};
  joint_->filter.predict(since);
  oldest_ = oldestPart(observations, fit, lights.size());
  const double most = contradictionOf(*answers[mostContradicted(answers)]);
  return most > largestContradiction(lights.size(), kFalseAlarm) ? Outcome::kTorn : Outcome::kJoint;
}

/// The only light without which all others fit; none when there is no such light, or another one.
std::optional<std::size_t> JointCalibration::oneTooMany(
    const std::vector<const LandmarkSolution*>& answers, const std::vector<std::size_t>& lights) {
  std::optional<std::size_t> found;
  for (std::size_t light : lights) {
    std::vector<std::size_t> others = lights;
    others.erase(std::find(others.begin(), others.end(), light));
    if (others.size() < 2 || fitTogether(answers, others) != Outcome::kJoint) continue;
    if (found) return std::nullopt;
    found = light;
  }
  return found;
}

double JointCalibration::contradictionOf(const LandmarkSolution& answer) const {
  return contradiction(answer.average.mount(), joint_->filter.estimate().mount());
}

std::size_t JointCalibration::mostContradicted(
    const std::vector<const LandmarkSolution*>& answers) const {
  return *std::max_element(joint_->lights.begin(), joint_->lights.end(),
                           [&](std::size_t a, std::size_t b) {
                             return contradictionOf(*answers[a]) < contradictionOf(*answers[b]);
                           });
}

Judgement JointCalibration::judge(const StateEstimate& estimate, bool is_clear) {
  const ErrorPriors& errors = config_.initializer.batch.errors;
  const StateEstimate known = withNearness(estimate, errors.nearness_stddev_m);
  if (!meetsTargets(known.mount(), config_.converged)) {
    return notYetConverged(known, errors, formatted(" by %d lights", known.layout.lights),
                           "keep driving straight lines and turns near them");
  }
  if (!is_clear) {
    return {CalibrationState::kConverging,
            "accurate enough, but two lights do not quite agree: drive on"};
  }
  return claimed_.claim(estimate.mount(), motionOf(record_.entries(), record_.beginning()));
}

}  // namespace bearing_calibration::core
