#include "bearing_calibration/calibration/joint_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bearing_calibration/calibration/lights_agreement.h"
#include "bearing_calibration/calibration/record_weights.h"
#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

/// A turn known worse than this is beyond what a linearised filter can follow.
constexpr double kUnknownTurnStddev_rad = 0.5;

/// The record with some of its lights, in another order.
std::vector<LightsImage> imagesOf(const std::vector<LightsImage>& images,
                                  const std::vector<std::size_t>& lights) {
  std::vector<LightsImage> chosen = images;
  for (std::size_t i = 0; i < images.size(); ++i) {
    chosen[i].lights = {};
    for (std::size_t k = 0; k < lights.size(); ++k) {
      chosen[i].lights.at(k) = images[i].lights.at(lights[k]);
    }
  }
  return chosen;
}

bool fitsWell(const LightsFit& fit, const InitializerConfig& config) {
  const double n = fit.degrees_of_freedom;
  return fit.settled && n > 0 &&
         fit.chi_square < n + config.max_chi_square_sigmas * std::sqrt(2.0 * n);
}

/// Nobody knows better where wheels slipped than the surest light does: what its own answers differ
/// by (see averageOverSlips) stays in the mount's covariance.
void addSpread(const OwnAnswer& surest, LightsEstimate* estimate) {
  const MountEstimate average = mountFromCartesian(surest.average.cartesian);
  const MountEstimate best = mountFromCartesian(surest.fit.at_last_sight);
  Eigen::Vector3d shift = average.mean - best.mean;
  shift.z() = wrapAngle(shift.z());
  const Eigen::Matrix3d spread = average.covariance - best.covariance + shift * shift.transpose();
  if (spread.trace() > 0.0) estimate->covariance.topLeftCorner<3, 3>() += spread;
}

}  // namespace

JointCalibration::JointCalibration(const CalibratorConfig& config)
    : config_(config), record_(config.initializer.record) {}

void JointCalibration::look(const LightsImage& image) {
  motion_since_record_ = append(motion_since_record_, image.motion);
  const bool shows_any = std::any_of(image.lights.begin(), image.lights.end(),
                                     [](const LightSight& sight) { return sight.isSeen(); });
  if (shows_any) {
    LightsImage kept = image;
    kept.motion = motion_since_record_;
    record_.add(kept);
    motion_since_record_ = {};
  }
  if (!joint_) return;
  if (image.motion.covariance(2, 2) > kUnknownTurnStddev_rad * kUnknownTurnStddev_rad) {
    joint_.reset();
    return;
  }
  LightsEstimate& estimate = joint_->estimate;
  propagate(lineariseMotion(estimate.layout, estimate.mean, image.motion, Eigen::Vector3d::Zero()),
            &estimate);
  for (std::size_t i = 0; i < joint_->lights.size(); ++i) {
    const LightSight& sight = image.lights.at(joint_->lights[i]);
    if (!sight.isSeen()) continue;
    const LightsVector about = estimate.mean;
    updateByAzimuth(about, static_cast<int>(i), sight.azimuth_rad,
                    widening_[i] * sight.azimuth_variance_rad2, image.nearby, &estimate);
  }
}

void JointCalibration::forget(std::size_t light) {
  record_.forget(light);
  if (joint_ && std::count(joint_->lights.begin(), joint_->lights.end(), light) > 0) {
    joint_.reset();
  }
}

void JointCalibration::review(const std::vector<const OwnAnswer*>& answers,
                              const std::optional<MountEstimate>& earlier) {
  std::vector<std::size_t> lights;
  std::vector<MountEstimate> mounts;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i] == nullptr) continue;
    lights.push_back(i);
    mounts.push_back(mountFromCartesian(answers[i]->average.cartesian));
  }
  const LightsAgreement agreement = compareLights(mounts);
  contradicting_.clear();
  for (std::size_t i : agreement.contradicting) contradicting_.push_back(lights[i]);
  joint_.reset();
  outcome_ = agreement.has_majority || lights.empty() ? Outcome::kTooFew : Outcome::kTorn;
  if (outcome_ == Outcome::kTorn || agreement.agreeing.size() < 2) return;

  Joint joint;
  std::vector<const OwnAnswer*> taken;
  widening_.clear();
  for (std::size_t i : agreement.agreeing) {
    joint.lights.push_back(lights[i]);
    taken.push_back(answers[lights[i]]);
    widening_.push_back(wideningFor(taken.back()->fit.correlation));
  }
  const std::vector<LightsImage> images = imagesOf(record_.entries(), joint.lights);
  const BatchConfig& batch = config_.initializer.batch;
  const LightsFit fit = fitLights(images, startFromAnswers(images, taken, batch.errors), batch);
  outcome_ = fitsWell(fit, config_.initializer) ? Outcome::kJoint : Outcome::kUnfit;
  if (outcome_ == Outcome::kUnfit) return;
  joint.estimate = fit.last;
  addSpread(surestOf(taken), &joint.estimate);
  if (earlier) fuseMount(*earlier, &joint.estimate);
  joint.judgement = judge(joint.estimate, agreement.is_clear);
  joint_ = joint;
}

Judgement JointCalibration::judge(const LightsEstimate& estimate, bool is_clear) const {
  const Eigen::Vector3d stddev = estimate.mount().covariance.diagonal().cwiseSqrt();
  char text[256];
  if (!meetsTargets(estimate.mount(), config_.converged)) {
    std::snprintf(
        text, sizeof(text),
        "position known to %.3f m and yaw to %.2f deg by %d lights: keep driving straight "
        "lines and turns near them",
        stddev.head<2>().maxCoeff(), degreesFromRadians(stddev.z()), estimate.layout.lights);
    return {CalibrationState::kConverging, text};
  }
  if (!is_clear) {
    return {CalibrationState::kConverging,
            "known well enough, but two lights do not quite agree: drive on"};
  }
  return {CalibrationState::kConverged, adviceFor(CalibrationState::kConverged)};
}

}  // namespace bearing_calibration
