#include "bearing_calibration/calibration/lights_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/calibration/record_weights.h"
#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

constexpr int kMostIterations = 15;
/// Of the last step, squared over its covariance: a hundredth of a standard deviation.
constexpr double kSettledStep = 1e-4;
/// Bearings are judged by a path this near to the end.
constexpr double kNearStep = 1.0;
constexpr int kMostRejectionRounds = 5;

Pose2 corrected(const OdometryIncrement& motion, const ErrorVector& errors) {
  return correctMotion<kErrorCount>(motion, errors).start_from_end;
}

Pose2 withError(const Pose2& measured, const Eigen::Vector3d& error) {
  return {measured.position_m + error.head<2>(), wrapAngle(measured.yaw_rad + error.z())};
}

/// The errors of all motions that bring the base where a light's own fit has it. Between two of its
/// sights the last motion carries all of it.
std::vector<Eigen::Vector3d> motionErrorsOf(const std::vector<LightsImage>& images,
                                            const OwnAnswer& answer) {
  const ErrorVector& errors = answer.fit.errors.mean;
  std::vector<Eigen::Vector3d> motion_errors(images.size(), Eigen::Vector3d::Zero());
  std::size_t sight = 0;
  Pose2 since_sight;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Pose2 measured = corrected(images[i].motion, errors);
    while (sight < answer.stamps.size() && answer.stamps[sight] < images[i].stamp) ++sight;
    const bool is_sight = sight < answer.stamps.size() && answer.stamps[sight] == images[i].stamp;
    if (!is_sight) {
      since_sight = since_sight * measured;
      continue;
    }
    if (sight > 0 && i > 0) {
      // the fit's motion between its sights, as far as one last motion can make it
      const Pose2 whole = withError(since_sight * measured, answer.fit.path[sight].motion_error);
      const Pose2 wanted = since_sight.inverse() * whole;
      motion_errors[i] << wanted.position_m - measured.position_m,
          wrapAngle(wanted.yaw_rad - measured.yaw_rad);
    }
    since_sight = {};
  }
  return motion_errors;
}

/// Where a light's own fit has it, seen from the base at the last image.
Eigen::Vector2d lightAtEnd(const std::vector<LightsImage>& images, const OwnAnswer& answer,
                           const std::vector<Eigen::Vector3d>& motion_errors,
                           const ErrorVector& errors) {
  Eigen::Vector2d light = answer.fit.path.back().state.head<2>();
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].stamp <= answer.stamps.back()) continue;
    light = withError(corrected(images[i].motion, errors), motion_errors[i]).inverse() * light;
  }
  return light;
}

LightsWeights weightsFrom(const std::vector<LightsImage>& images,
                          const std::vector<const OwnAnswer*>& answers) {
  LightsWeights weights;
  weights.images.resize(images.size());
  for (std::size_t light = 0; light < answers.size(); ++light) {
    const OwnAnswer& answer = *answers[light];
    weights.widening.at(light) = wideningFor(answer.fit.correlation);
    auto rejected = answer.fit.rejected.begin();
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto is_before = [&](std::size_t at) { return answer.stamps[at] < images[i].stamp; };
      while (rejected != answer.fit.rejected.end() && is_before(*rejected)) ++rejected;
      const bool is_rejected =
          rejected != answer.fit.rejected.end() && answer.stamps[*rejected] == images[i].stamp;
      weights.images[i].use.at(light) = images[i].lights.at(light).isSeen() && !is_rejected;
    }
    for (std::size_t slip : answer.fit.slips) {
      for (std::size_t i = 1; i < images.size(); ++i) {
        if (isNearSlip(images[i].stamp, answer.stamps[slip])) weights.images[i].slipped = true;
      }
    }
  }
  for (std::size_t i = 0; i + 1 < images.size(); ++i) {
    if (weights.images[i].slipped && weights.images[i + 1].slipped) weights.images[i].use = {};
  }
  return weights;
}

/// One fit, from its start to the end of its iterations.
class Fit {
 public:
  Fit(const std::vector<LightsImage>& images, const LightsStart& start, const BatchConfig& config)
      : images_(images),
        layout_(start.layout),
        config_(config),
        decided_(start.weights),
        weights_(start.weights),
        path_(start.path) {}

  LightsFit run();

 private:
  double takeStep();
  bool rejectOutliers();
  bool hasLikelyErrors() const;

  const std::vector<LightsImage>& images_;
  const LightsLayout layout_;
  const BatchConfig& config_;
  const LightsWeights& decided_;
  LightsWeights weights_;
  LightsPath path_;
  LightsPass pass_;
  int rejection_rounds_ = 0;
};

/// @returns how far it went at the last image, squared over its covariance
double Fit::takeStep() {
  pass_ = smoothLights(images_, weights_, layout_, path_, config_.errors);
  const LightsVector& last = pass_.last.mean;
  LightsVector change = last - path_.states.back();
  path_ = pathTo(layout_, last, images_, pass_.motion_errors);
  // Errors that are not looked for have no variance.
  LightsMatrix covariance = pass_.last.covariance;
  for (int i = 0; i < layout_.errors; ++i) {
    if (config_.errors.stddev(i) > 0.0) continue;
    covariance(kMountSize + i, kMountSize + i) = 1.0;
    change(kMountSize + i) = 0.0;
  }
  return change.dot(covariance.ldlt().solve(change));
}

/// Bearings that each light's own fit has kept, or has not judged yet, and that do not fit here.
bool Fit::rejectOutliers() {
  if (config_.reject_sigmas <= 0.0 || ++rejection_rounds_ > kMostRejectionRounds) return false;
  bool changed = false;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    for (int light = 0; light < layout_.lights; ++light) {
      const auto at = static_cast<std::size_t>(light);
      if (!decided_.images[i].use.at(at)) continue;
      const LightSight& sight = images_[i].lights.at(at);
      const double expected =
          expectAzimuth(layout_, path_.states[i], light, images_[i].nearby).azimuth_rad;
      const double residual = wrapAngle(sight.azimuth_rad - expected);
      const double limit = config_.reject_sigmas * config_.reject_sigmas *
                           weights_.widening.at(at) * sight.azimuth_variance_rad2;
      const bool use = residual * residual <= limit;
      changed = changed || use != weights_.images[i].use.at(at);
      weights_.images[i].use.at(at) = use;
    }
  }
  return changed;
}

/// As in the batch of one light: an answer whose errors are far beyond their priors has run away.
bool Fit::hasLikelyErrors() const {
  constexpr double kMostSigmas = 6.0;
  const ErrorVector errors = errorsOf(layout_, pass_.last.mean);
  return (errors.cwiseAbs().array() <= kMostSigmas * config_.errors.stddev.array()).all();
}

LightsFit Fit::run() {
  LightsFit fit;
  while (!fit.settled && fit.iterations < kMostIterations) {
    ++fit.iterations;
    const double step = takeStep();
    if (!std::isfinite(step)) return fit;
    const bool changed = step < kNearStep && rejectOutliers();
    fit.settled = !changed && step < kSettledStep;
  }
  fit.last = pass_.last;
  double& yaw = fit.last.mean(kMountSize - 1);
  yaw = wrapAngle(yaw);
  fit.chi_square = pass_.chi_square;
  fit.degrees_of_freedom = std::max(0, pass_.bearings - kMountSize - 2 * layout_.lights);
  fit.settled = fit.settled && hasLikelyErrors();
  return fit;
}

}  // namespace

const OwnAnswer& surestOf(const std::vector<const OwnAnswer*>& answers) {
  const auto size = [](const OwnAnswer* answer) {
    return mountFromCartesian(answer->average.cartesian).covariance.determinant();
  };
  return **std::min_element(
      answers.begin(), answers.end(),
      [&](const OwnAnswer* a, const OwnAnswer* b) { return size(a) < size(b); });
}

LightsStart startFromAnswers(const std::vector<LightsImage>& images,
                             const std::vector<const OwnAnswer*>& answers,
                             const ErrorPriors& errors) {
  const OwnAnswer& surest = surestOf(answers);
  LightsStart start;
  start.layout = {errorsInUse(errors), static_cast<int>(answers.size())};
  const std::vector<Eigen::Vector3d> motion_errors = motionErrorsOf(images, surest);
  LightsVector last(start.layout.size());
  last.head<kMountSize>() = surest.fit.at_last_sight.mean.tail<kMountSize>();
  last.segment(kMountSize, start.layout.errors) = surest.fit.errors.mean.head(start.layout.errors);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    last.segment<2>(start.layout.lightAt(static_cast<int>(i))) =
        lightAtEnd(images, *answers[i], motion_errors, surest.fit.errors.mean);
  }
  start.path = pathTo(start.layout, last, images, motion_errors);
  start.weights = weightsFrom(images, answers);
  return start;
}

LightsFit fitLights(const std::vector<LightsImage>& images, const LightsStart& start,
                    const BatchConfig& config) {
  return Fit(images, start, config).run();
}

}  // namespace bearing_calibration
