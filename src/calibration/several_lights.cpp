#include "bearing_calibration/calibration/several_lights.h"

#include <algorithm>
#include <iterator>

#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {
namespace {

/// A light that has not been found out and not been seen for so long makes room for another.
constexpr std::chrono::seconds kForgottenAfter{30};

bool isSame(const Bearing& bearing, const Observation& observation) {
  return bearing.azimuth_rad == observation.azimuth_rad &&
         bearing.azimuth_variance_rad2 == observation.azimuth_variance_rad2;
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

AssociationOutcome SeveralLights::process(const Frame& frame) {
  std::vector<Bearing> left = frame.image.candidates;
  Frame shown = frame;
  shown.motion = withHiddenTurn(frame);
  LightsImage seen{frame.image.stamp, shown.motion, frame.nearby, {}};
  AssociationOutcome first = AssociationOutcome::of(shown);
  is_ambiguous_ = false;
  const Expected expected = expectedIn(shown);
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const bool was_found = lights_[i].isFound();
    shown.image.candidates = offeredTo(i, left, expected);
    const AssociationOutcome outcome = lights_[i].process(shown);
    take(i, outcome, &left, &seen);
    if (was_found && outcome.lost_light) ++new_starts_;
    if (outcome.kind == Association::Kind::kAmbiguous) is_ambiguous_ = true;
    if (i == 0) first = outcome;
  }
  if (!isMany()) return first;
  const bool is_empty = lights_.empty();
  if (!is_ambiguous_) welcome(shown, &left, &seen);
  if (is_empty && !lights_.empty() && seen.lights[0].isSeen()) {
    first.kind = Association::Kind::kFound;
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

/// Where lights that nobody has numbered are expected; none of one alone, which tells no turn from
/// a mistake, and has nobody to share an image with.
SeveralLights::Expected SeveralLights::expectedIn(const Frame& frame) const {
  Expected expected(lights_.size());
  if (lights_.size() < 2) return expected;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (!lights_[i].isFound() || lights_[i].lightId() != kUnknownLight) continue;
    expected[i] = lights_[i].predictAzimuthAfter(frame.motion, frame.nearby);
  }
  return expected;
}

/// The motion with what a slip has hidden of it, where that shows at once. Only of lights without
/// numbers: each of the others is looked for anew by itself.
OdometryIncrement SeveralLights::withHiddenTurn(const Frame& frame) const {
  constexpr double kSlid_m = 0.1;
  constexpr double kTurned_rad = 0.05;
  std::vector<AzimuthPrediction> expected;
  std::vector<Bearing> candidates;  // all of one sensor, whose noise each light has found
  const Expected all = expectedIn(frame);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i]) continue;
    expected.push_back(*all[i]);
    candidates = withNoise(frame.image.candidates, lights_[i].noise(), all[i]->range_m);
  }
  const std::optional<double> turn_rad = hiddenTurn(expected, candidates);
  if (!turn_rad) return frame.motion;
  OdometryIncrement slip;
  slip.has_unseen = true;
  slip.start_from_end.yaw_rad = *turn_rad;
  slip.covariance.diagonal() << kSlid_m * kSlid_m, kSlid_m * kSlid_m, kTurned_rad * kTurned_rad;
  return append(frame.motion, slip);
}

bool SeveralLights::isAnySeenAt(Stamp stamp) const {
  return std::any_of(lights_.begin(), lights_.end(),
                     [stamp](const MountCalibration& light) { return light.lastSeen() == stamp; });
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

/// By the noise that the light has found.
bool SeveralLights::mayBeOf(std::size_t light, const Bearing& candidate,
                            const Expected& expected) const {
  if (!expected[light]) return false;
  const Bearing noisy = withNoise(candidate, lights_[light].noise(), expected[light]->range_m);
  return isWhereExpected(*expected[light], noisy);
}

/// Not what is another one's, by its number or by where that one is expected: a light that is
/// hidden would be lost by the bearings of those that are not, or take one of theirs.
bool SeveralLights::isOffered(const Bearing& candidate, std::size_t light,
                              const Expected& expected) const {
  constexpr double kMuchSurer = 9.0;  // of variances
  const std::int32_t own_id = lights_[light].lightId();
  const bool is_numbered = candidate.light_id != kUnknownLight;
  if (is_numbered && candidate.light_id == own_id) return true;
  if (is_numbered) return own_id == kUnknownLight && !isOwned(candidate.light_id);
  const bool is_expected = mayBeOf(light, candidate, expected);
  for (std::size_t other = 0; other < lights_.size(); ++other) {
    if (other == light || !mayBeOf(other, candidate, expected)) continue;
    const bool is_surer = !is_expected || expected[light]->variance_rad2 >
                                              kMuchSurer * expected[other]->variance_rad2;
    if (is_surer) return false;
  }
  return true;
}

/// What the lights before it have left of an image, without what is another one's.
std::vector<Bearing> SeveralLights::offeredTo(std::size_t light, const std::vector<Bearing>& left,
                                              const Expected& expected) const {
  std::vector<Bearing> offered;
  std::copy_if(left.begin(), left.end(), std::back_inserter(offered),
               [&](const Bearing& candidate) { return isOffered(candidate, light, expected); });
  return offered;
}

/// What a light has taken of an image is not left for the next one.
void SeveralLights::take(std::size_t light, const AssociationOutcome& outcome,
                         std::vector<Bearing>* left, LightsImage* seen) {
  if (outcome.lost_light) joint_.forget(light);
  if (outcome.kind != Association::Kind::kFound) return;
  seen->lights.at(light) = {outcome.observation.azimuth_rad,
                            outcome.observation.azimuth_variance_rad2,
                            outcome.observation.elevation};
  const auto taken = std::find_if(left->begin(), left->end(), [&](const Bearing& candidate) {
    return isSame(candidate, outcome.observation);
  });
  if (taken != left->end()) left->erase(taken);
}

/// What no light has taken may be a further one.
void SeveralLights::welcome(Frame frame, std::vector<Bearing>* left, LightsImage* seen) {
  const bool has_newcomer =
      std::any_of(lights_.begin(), lights_.end(), [](const MountCalibration& light) {
        return light.lightId() == kUnknownLight && !light.isFound();
      });
  bool may_be_unknown = !has_newcomer;
  for (;;) {
    const auto newcomer = std::find_if(left->begin(), left->end(), [&](const Bearing& candidate) {
      return candidate.light_id == kUnknownLight ? may_be_unknown : !isOwned(candidate.light_id);
    });
    const auto place = placeForAnother(frame.image.stamp);
    if (newcomer == left->end() || !place) return;
    if (newcomer->light_id == kUnknownLight) may_be_unknown = false;
    if (*place == lights_.size()) {
      lights_.push_back(newLight());
    } else {
      lights_[*place] = newLight();
      joint_.forget(*place);
    }
    frame.image.candidates = {*newcomer};
    left->erase(newcomer);
    take(*place, lights_[*place].process(frame), left, seen);
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

/// A mount that has moved is noticed by all lights that are in view, though not at once; a light
/// that was moved says the same, but alone.
std::optional<Judgement> SeveralLights::agreeOnMountMoved() const {
  std::vector<std::size_t> moved;
  double longest_m = 0.0;
  std::optional<Judgement> alone;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const std::optional<double> moved_for_m = lights_[i].movedFor();
    if (!moved_for_m) continue;
    moved.push_back(i);
    longest_m = std::max(longest_m, *moved_for_m);
    if (*moved_for_m >= kNoticedWithin_m) continue;
    alone = {CalibrationState::kConverging,
             nameOf(i) + " reports that the mount has moved, the others do not: drive on"};
  }
  if (moved.empty()) return std::nullopt;
  const double had_to_be_seen_m = std::max(0.0, longest_m - kNoticedWithin_m);  // ago, at most
  const bool is_time_up = longest_m >= kNoticedWithin_m;
  const auto denying = static_cast<std::size_t>(
      std::count_if(lights_.begin(), lights_.end(), [&](const MountCalibration& light) {
        return light.isFound() && !light.movedFor() &&
               (!is_time_up || light.unseenFor_m() <= had_to_be_seen_m);
      }));
  if (moved.size() >= denying) return *lights_[moved.back()].judgement();
  return alone;
}

void SeveralLights::startAnew() {
  lights_.clear();
  earlier_.reset();
  joint_ = JointCalibration(config_);
  mount_moved_.reset();
  restarted_ = true;
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
