#include "bearing_calibration/solve/batch_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/cancellation.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "bearing_calibration/solve/record_weights.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A fit has settled when its last step, squared over its covariance, is below this: a hundredth of
/// a standard deviation; while Huber's weights are still to be replaced, a tenth.
constexpr double kSettledStep = 1e-4;
constexpr double kSettledHuberStep = 1e-2;
/// After a slip the light's distance may be so uncertain that it never settles as well: then the
/// mount must settle to a thirtieth of a standard deviation, and the whole state to a half.
constexpr double kSettledSlipStep = 1e-3;
constexpr double kNearlySettledStep = 0.25;
constexpr int kMaxFailures = 6;
/// A slip itself can keep a fit from settling: after so many iterations slips are looked for.
constexpr int kNearAfterIterations = 4;

/// Levenberg's damping: how far a pass may go after so many failures in a row.
SmootherPrior dampedPrior(int failures) {
  if (failures == 0) return kFreePass;
  constexpr double kFirstPosition_m = 2.0;
  constexpr double kFirstYaw_rad = 1.0;
  const double scale = std::pow(0.2, failures - 1);
  return {kFirstPosition_m * scale, kFirstYaw_rad * scale};
}

/// One fit of one record, from the start to the end of its iterations. Slips are looked for as soon
/// as the fit is near; then the weights go from Huber's to plain ones without the outliers.
class Fit {
 public:
  Fit(const std::vector<Observation>& observations, const RecordTrack& track,
      const BatchConfig& config, const SlipHypothesis& slips,
      const std::optional<RecordBeginning>& beginning)
      : config_(config),
        observations_(observations),
        beginning_(beginning),
        weights_(observations, track.is_plausible, config, slips),
        path_(track.path) {
    weights_.weighBearings(path_);
  }

  BatchEstimate run();

 private:
  enum class Stage { kHuber, kRejecting, kWidening, kDone };

  bool step();
  double costOf(const SmootherPass& pass, const RecordPath& path) const;
  bool hasLikelyErrors() const;
  bool hasSettled() const;
  void nextStage();
  void judgeInnovations(BatchEstimate& estimate) const;

  const BatchConfig& config_;
  const std::vector<Observation>& observations_;
  const std::optional<RecordBeginning>& beginning_;
  RecordWeights weights_;
  RecordPath path_;
  SmootherPass pass_;
  SmootherPass settled_;  ///< before the variances were widened: what the fit is judged by
  Stage stage_ = Stage::kHuber;
  double cost_ = kInfinity;       ///< of path_, by the present weights; not known yet
  double last_step_ = kInfinity;  ///< of mount and lights at the end, squared over its covariance
  double last_mount_step_ = kInfinity;
  bool near_ = false;  ///< so near the end that slips can be told
  int failures_ = 0;
};

/// The places of mount and lights in a state.
std::vector<int> placesOf(const StateLayout& layout) {
  std::vector<int> places;
  for (int i = 0; i < layout.size(); ++i) {
    if (i < kMountSize || i >= layout.lastingSize()) places.push_back(i);
  }
  return places;
}

/// Errors of the robot far beyond their priors are the sign of a fit that has run away.
bool Fit::hasLikelyErrors() const {
  constexpr double kMostSigmas = 6.0;
  const ErrorVector most = kMostSigmas * config_.errors.stddev;
  const ErrorVector off = pass_.path.errors - config_.errors.mean;
  return (off.cwiseAbs().array() <= most.array()).all();
}

/// What a path costs: its bearings, its motions, and what was known beforehand.
double Fit::costOf(const SmootherPass& pass, const RecordPath& path) const {
  double cost = pass.motion_cost + weights_.bearingCost(path);
  if (beginning_) return cost + pass.beginning_cost;  // with the priors of the errors in it
  for (int i = 0; i < kErrorCount; ++i) {
    const double stddev = config_.errors.stddev(i);
    const double off = path.errors(i) - config_.errors.mean(i);
    if (stddev > 0.0) cost += std::pow(off / stddev, 2);
  }
  return cost;
}

/// One Gauss-Newton step; false when it would not lower the cost.
bool Fit::step() {
  SmootherPass pass = smooth(observations_, weights_.observations(), path_, dampedPrior(failures_),
                             config_.errors, beginning_ ? &beginning_->known : nullptr);
  const double cost = costOf(pass, pass.path);
  // The motions' share is that of the linearised problem, and Huber's weights follow a step behind:
  // only a cost that clearly rises is a reason to hold back.
  constexpr double kTolerance = 1.0;
  constexpr double kRelativeTolerance = 0.2;
  if (!(cost <= cost_ * (1.0 + kRelativeTolerance) + kTolerance)) return false;
  const StateLayout& layout = pass.last.layout;
  const std::size_t end = path_.points.size() - 1;
  const std::vector<int> places = placesOf(layout);
  const StateVector change =
      (pass.path.stateAt(layout, end) - path_.stateAt(layout, end))(places).eval();
  const StateMatrix covariance = pass.last.covariance(places, places);
  const Eigen::Vector3d mount_change = change.head<kMountSize>();
  const Eigen::Matrix3d mount_covariance = covariance.topLeftCorner<kMountSize, kMountSize>();
  last_step_ = change.dot(covariance.ldlt().solve(change));
  last_mount_step_ = mount_change.dot(mount_covariance.ldlt().solve(mount_change));
  cost_ = cost;
  path_ = pass.path;
  pass_ = std::move(pass);
  return true;
}

bool Fit::hasSettled() const {
  const bool refined_later = stage_ == Stage::kHuber && config_.reject_sigmas > 0.0;
  if (last_step_ < (refined_later ? kSettledHuberStep : kSettledStep)) return true;
  const double limit = refined_later ? kSettledHuberStep : kSettledSlipStep;
  return !weights_.slips().empty() && last_mount_step_ < limit && last_step_ < kNearlySettledStep;
}

/// What to do when the fit has settled.
void Fit::nextStage() {
  cost_ = kInfinity;
  if (stage_ == Stage::kHuber && config_.reject_sigmas > 0.0) {
    stage_ = Stage::kRejecting;
    weights_.endHuber(path_);
    weights_.rejectOutliers(pass_);
    return;
  }
  if (stage_ == Stage::kRejecting && weights_.rejectOutliers(pass_)) return;
  const bool may_widen = stage_ != Stage::kWidening && config_.widen_for_correlation;
  if (may_widen) settled_ = pass_;
  const bool widened = may_widen && weights_.widenForCorrelation(pass_, path_);
  stage_ = widened ? Stage::kWidening : Stage::kDone;
}

void Fit::judgeInnovations(BatchEstimate& estimate) const {
  const SmootherPass& pass = settled_.observations.empty() ? pass_ : settled_;
  int used = 0;
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    estimate.mount_displacements.push_back(pass_.observations[i].mount_displacement);
    estimate.suspicion = std::max(estimate.suspicion, pass.observations[i].slip_gain);
    estimate.nis.push_back(std::numeric_limits<double>::quiet_NaN());
    if (!weights_.observations()[i].use_bearing) {
      estimate.rejected.push_back(i);
      continue;
    }
    ++used;
    const SmoothedObservation& observation = pass.observations[i];
    estimate.nis.back() = observation.azimuth.nis();
    estimate.chi_square += estimate.nis.back();
  }
  estimate.slips = weights_.slips();
  std::sort(estimate.slips.begin(), estimate.slips.end());
  const int lights = pass.path.lights();
  const int slips = std::min(2 * lights, 3) * static_cast<int>(estimate.slips.size());
  const int unknown = beginning_ ? 0 : kMountSize + 2 * lights;
  estimate.degrees_of_freedom = std::max(0, used - unknown - slips);
}

BatchEstimate Fit::run() {
  BatchEstimate estimate;
  while (stage_ != Stage::kDone && estimate.iterations < config_.max_iterations) {
    endIfCancelled();
    ++estimate.iterations;
    if (!step()) {
      if (++failures_ > kMaxFailures || beginning_) break;  // a beginning cannot be damped
      continue;
    }
    const bool free = failures_ == 0;
    failures_ = std::max(0, failures_ - 1);
    near_ = near_ || last_step_ < kNearlySettledStep || estimate.iterations >= kNearAfterIterations;
    if (free && near_ && weights_.giveUpSlip(pass_)) {
      cost_ = kInfinity;
    } else if (free && hasSettled()) {
      nextStage();
    } else if (stage_ == Stage::kHuber) {
      weights_.weighBearings(path_);
    }
  }
  if (pass_.observations.empty()) return estimate;
  estimate.converged = stage_ == Stage::kDone && pass_.last.mean.allFinite() && hasLikelyErrors();
  estimate.last = pass_.last;
  estimate.last.wrapYaw();
  estimate.cost = costOf(pass_, path_) + weights_.costOfDisbelief(path_);
  estimate.correlation = weights_.correlation();
  estimate.weights = weights_.observations();
  estimate.beginning = beginning_;
  judgeInnovations(estimate);
  estimate.path = std::move(path_);
  return estimate;
}

}  // namespace

void BatchConfig::declare(Parameters& params) {
  params.that(max_iterations > 0, "batch/max_iterations must be greater than 0, but is " +
                                      std::to_string(max_iterations));
  params.notNegative("batch/huber_sigmas", huber_sigmas);
  params.notNegative("batch/reject_sigmas", reject_sigmas);
  params.notNegative("batch/slip_gain", slip_gain);
  errors.declare(params);
  params.that(max_slips >= 0,
              "batch/max_slips must not be negative, but is " + std::to_string(max_slips));
}

double BatchEstimate::inlierFraction() const {
  if (nis.empty()) return 0.0;
  return 1.0 - static_cast<double>(rejected.size()) / static_cast<double>(nis.size());
}

Scatter BatchEstimate::scatter() const {
  Scatter all = beginning ? beginning->scatter : Scatter();
  all += scatterOf(mount_displacements, 0, mount_displacements.size());
  return all;
}

RecordStart surestStart(const BatchEstimate& fit) {
  std::size_t longest_begin = 0;
  std::size_t longest = 0;
  std::size_t begin = 0;
  const auto endStretch = [&](std::size_t end) {
    if (end - begin > longest) {
      longest_begin = begin;
      longest = end - begin;
    }
    begin = end;
  };
  for (std::size_t slip : fit.slips) endStretch(slip);
  endStretch(fit.path.points.size());
  const std::size_t observation = longest_begin + longest / 2;
  RecordStart start(fit.last, observation);
  start.mount = fit.path.mount;
  start.lights_in_base = fit.path.points[observation].lights_in_base;
  return start;
}

BatchEstimator::BatchEstimator(const BatchConfig& config) : config_(validated(config)) {}

BatchEstimate BatchEstimator::estimate(const std::vector<Observation>& observations,
                                       const RecordStart& start, const SlipHypothesis& slips,
                                       const std::optional<RecordBeginning>& beginning) const {
  if (start.observation >= observations.size()) {
    throw std::invalid_argument("the start of a batch estimate is not at one of its observations");
  }
  return estimate(observations, trackLights(observations, start), slips, beginning);
}

BatchEstimate BatchEstimator::estimate(const std::vector<Observation>& observations,
                                       const RecordTrack& track, const SlipHypothesis& slips,
                                       const std::optional<RecordBeginning>& beginning) const {
  const auto is_outside = [&observations](std::size_t i) { return i >= observations.size(); };
  if (observations.empty() || track.path.points.size() != observations.size() ||
      track.is_plausible.size() != observations.size() ||
      std::any_of(slips.given_up.begin(), slips.given_up.end(), is_outside) ||
      std::any_of(slips.trusted.begin(), slips.trusted.end(), is_outside)) {
    throw std::invalid_argument(
        "the track or a supposed slip of a batch estimate is not at one of its observations");
  }
  const StateLayout layout{errorsInUse(config_.errors), track.path.lights()};
  if (beginning && (beginning->known.layout.errors != layout.errors ||
                    beginning->known.layout.lights != layout.lights)) {
    throw std::invalid_argument(
        "the beginning of a batch estimate is not of its lights and the errors in use");
  }
  for (const Observation& observation : observations) {
    if (!(observation.azimuth_variance_rad2 > 0.0)) {
      throw std::invalid_argument("azimuth variance " +
                                  std::to_string(observation.azimuth_variance_rad2) +
                                  " rad^2 is not positive");
    }
    if (observation.elevation && !(observation.elevation->variance_rad2 > 0.0)) {
      throw std::invalid_argument("elevation variance " +
                                  std::to_string(observation.elevation->variance_rad2) +
                                  " rad^2 is not positive");
    }
    if (observation.light < 0 || observation.light >= track.path.lights()) {
      throw std::invalid_argument("light " + std::to_string(observation.light) +
                                  " is not on the track");
    }
  }
  return Fit(observations, track, config_, slips, beginning).run();
}

StateEstimate BatchEstimator::knownAt(std::size_t observation,
                                      const std::vector<Observation>& observations,
                                      const BatchEstimate& fit) const {
  const auto until = [observation](const auto& all) {
    return std::vector(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(observation + 1));
  };
  const RecordPath path{until(fit.path.points), fit.path.mount, fit.path.errors};
  const SmootherPass pass = smooth(until(observations), until(fit.weights), path, kFreePass,
                                   config_.errors, fit.known());
  return withoutLearntScale(pass.last, config_.errors);
}

}  // namespace bearing_calibration::core
