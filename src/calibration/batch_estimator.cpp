#include "bearing_calibration/calibration/batch_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "bearing_calibration/calibration/cartesian_smoother.h"
#include "bearing_calibration/calibration/record_weights.h"
#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration {
namespace {

constexpr int kStateSize = 5;
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
  Fit(const std::vector<Sight>& sights, const LightTrack& track, const ErrorVector& errors,
      const BatchConfig& config, const SlipHypothesis& slips)
      : config_(config), sights_(sights), weights_(sights, track.is_plausible, config, slips) {
    path_.errors = errors;
    for (const Vector5& state : track.states) {
      path_.points.push_back({state, Eigen::Vector3d::Zero()});
    }
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
  const std::vector<Sight>& sights_;
  RecordWeights weights_;
  RecordPath path_;
  SmootherPass pass_;
  SmootherPass settled_;  ///< before the variances were widened: what the fit is judged by
  Stage stage_ = Stage::kHuber;
  double cost_ = kInfinity;       ///< of path_, by the present weights; not known yet
  double last_step_ = kInfinity;  ///< of the state at the last sight, squared over its covariance
  double last_mount_step_ = kInfinity;
  bool near_ = false;  ///< so near the end that slips can be told
  int failures_ = 0;
};

/// Errors of the robot far beyond their priors are the sign of a fit that has run away.
bool Fit::hasLikelyErrors() const {
  constexpr double kMostSigmas = 6.0;
  const ErrorVector most = kMostSigmas * config_.errors.stddev;
  const ErrorVector off = pass_.last.errors.mean - config_.errors.mean;
  return (off.cwiseAbs().array() <= most.array()).all();
}

/// What a path costs: its bearings, its motions and the robot's errors.
double Fit::costOf(const SmootherPass& pass, const RecordPath& path) const {
  double cost = pass.motion_cost + weights_.bearingCost(path);
  for (int i = 0; i < kErrorCount; ++i) {
    const double stddev = config_.errors.stddev(i);
    const double off = path.errors(i) - config_.errors.mean(i);
    if (stddev > 0.0) cost += std::pow(off / stddev, 2);
  }
  return cost;
}

/// One Gauss-Newton step; false when it would not lower the cost.
bool Fit::step() {
  SmootherPass pass =
      smooth(sights_, weights_.sights(), path_, dampedPrior(failures_), config_.errors);
  RecordPath path;
  path.errors = pass.last.errors.mean;
  path.points.reserve(sights_.size());
  for (const SmoothedSight& sight : pass.sights) path.points.push_back(sight.point);
  const double cost = costOf(pass, path);
  // The motions' share is that of the linearised problem, and Huber's weights follow a step behind:
  // only a cost that clearly rises is a reason to hold back.
  constexpr double kTolerance = 1.0;
  constexpr double kRelativeTolerance = 0.2;
  if (!(cost <= cost_ * (1.0 + kRelativeTolerance) + kTolerance)) return false;
  const Vector5 change = path.points.back().state - path_.points.back().state;
  const Eigen::Vector3d mount_change = change.tail<3>();
  const Eigen::Matrix3d mount_covariance = pass.last.cartesian.covariance.bottomRightCorner<3, 3>();
  last_step_ = change.dot(pass.last.cartesian.covariance.ldlt().solve(change));
  last_mount_step_ = mount_change.dot(mount_covariance.ldlt().solve(mount_change));
  cost_ = cost;
  path_ = std::move(path);
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
  const SmootherPass& pass = settled_.sights.empty() ? pass_ : settled_;
  int used = 0;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    estimate.mount_jumps.push_back(pass_.sights[i].mount_jump);
    estimate.suspicion = std::max(estimate.suspicion, pass.sights[i].slip_gain);
    estimate.nis.push_back(std::numeric_limits<double>::quiet_NaN());
    if (!weights_.sights()[i].use_bearing) {
      estimate.rejected.push_back(i);
      continue;
    }
    ++used;
    const SmoothedSight& sight = pass.sights[i];
    estimate.nis.back() =
        sight.innovation_rad * sight.innovation_rad / sight.innovation_variance_rad2;
    estimate.chi_square += estimate.nis.back();
  }
  estimate.slips = weights_.slips();
  std::sort(estimate.slips.begin(), estimate.slips.end());
  estimate.degrees_of_freedom =
      std::max(0, used - kStateSize - 2 * static_cast<int>(estimate.slips.size()));
}

BatchEstimate Fit::run() {
  BatchEstimate estimate;
  while (stage_ != Stage::kDone && estimate.iterations < config_.max_iterations) {
    ++estimate.iterations;
    if (!step()) {
      if (++failures_ > kMaxFailures) break;
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
  if (pass_.sights.empty()) return estimate;
  estimate.converged =
      stage_ == Stage::kDone && pass_.last.cartesian.mean.allFinite() && hasLikelyErrors();
  estimate.at_last_sight = pass_.last.cartesian;
  estimate.errors = pass_.last.errors;
  estimate.at_last_sight.mean(CartesianIndex::kSensorYaw) =
      wrapAngle(estimate.at_last_sight.sensorYaw());
  estimate.cost = costOf(pass_, path_) + weights_.costOfDisbelief(path_);
  estimate.correlation = weights_.correlation();
  judgeInnovations(estimate);
  estimate.path = std::move(path_.points);
  return estimate;
}

}  // namespace

std::vector<std::string> BatchConfig::validate() const {
  Requirements require;
  require.that(max_iterations > 0, "batch/max_iterations must be greater than 0, but is " +
                                       std::to_string(max_iterations));
  require.notNegative("batch/huber_sigmas", huber_sigmas);
  require.notNegative("batch/reject_sigmas", reject_sigmas);
  require.notNegative("batch/slip_gain", slip_gain);
  require.add(errors.validate());
  require.that(max_slips >= 0,
               "batch/max_slips must not be negative, but is " + std::to_string(max_slips));
  return require.errors();
}

double BatchEstimate::inlierFraction() const {
  if (nis.empty()) return 0.0;
  return 1.0 - static_cast<double>(rejected.size()) / static_cast<double>(nis.size());
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
  endStretch(fit.path.size());
  const std::size_t sight = longest_begin + longest / 2;
  return {fit.path[sight].state, sight, fit.errors.mean};
}

BatchEstimator::BatchEstimator(const BatchConfig& config) : config_(validated(config)) {}

BatchEstimate BatchEstimator::estimate(const std::vector<Sight>& sights, const RecordStart& start,
                                       const SlipHypothesis& slips) const {
  const auto is_outside = [&sights](std::size_t i) { return i >= sights.size(); };
  if (is_outside(start.sight) ||
      std::any_of(slips.given_up.begin(), slips.given_up.end(), is_outside) ||
      std::any_of(slips.trusted.begin(), slips.trusted.end(), is_outside)) {
    throw std::invalid_argument(
        "the start or a supposed slip of a batch estimate is not at one of its sights");
  }
  for (const Sight& sight : sights) {
    if (!(sight.azimuth_variance_rad2 > 0.0)) {
      throw std::invalid_argument("azimuth variance " +
                                  std::to_string(sight.azimuth_variance_rad2) +
                                  " rad^2 is not positive");
    }
    if (sight.elevation && !(sight.elevation->variance_rad2 > 0.0)) {
      throw std::invalid_argument("elevation variance " +
                                  std::to_string(sight.elevation->variance_rad2) +
                                  " rad^2 is not positive");
    }
  }
  return Fit(sights, trackLight(sights, start), start.errors, config_, slips).run();
}

}  // namespace bearing_calibration
