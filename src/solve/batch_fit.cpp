#include "bearing_calibration/solve/batch_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bearing_calibration/common/cancellation.h"
#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {
namespace {

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

/// The places of mount and lights in a state.
std::vector<int> placesOf(const StateLayout& layout) {
  std::vector<int> places;
  for (int i = 0; i < layout.size(); ++i) {
    if (i < kMountSize || i >= layout.lastingSize()) places.push_back(i);
  }
  return places;
}

}  // namespace

BatchFit::BatchFit(const std::vector<Observation>& observations, const RecordTrack& track,
                   const BatchConfig& config, const SlipHypothesis& slips,
                   const std::optional<RecordBeginning>& beginning)
    : config_(config),
      observations_(observations),
      beginning_(beginning),
      weights_(observations, track.is_plausible, config, slips),
      path_(track.path) {
  weights_.weighBearings(path_);
}

/// Errors of the robot far beyond their priors are the sign of a fit that has run away.
bool BatchFit::hasLikelyErrors() const {
  constexpr double kMostSigmas = 6.0;
  const int errors = pass_.last.layout.errors;
  const ErrorVector most = kMostSigmas * config_.errors.stddev;
  const ErrorVector off = pass_.path.errors - config_.errors.mean;
  return (off.head(errors).cwiseAbs().array() <= most.head(errors).array()).all();
}

/// What a path costs: its bearings, its motions, and what was known beforehand.
double BatchFit::costOf(const SmootherPass& pass, const RecordPath& path) const {
  double cost = pass.motion_cost + weights_.bearingCost(path);
  if (beginning_) return cost + pass.beginning_cost;  // with the priors of the errors in it
  for (int i = 0; i < pass.last.layout.errors; ++i) {
    const double stddev = config_.errors.stddev(i);
    const double off = path.errors(i) - config_.errors.mean(i);
    if (stddev > 0.0) cost += std::pow(off / stddev, 2);
  }
  return cost;
}

/// One Gauss-Newton step; false when it would not lower the cost.
bool BatchFit::step(int iteration) {
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
  // Most fits settle before, some of them to and fro.
  constexpr int kUsualIterations = 20;
  const bool goes_back = iteration > kUsualIterations && goesBack(change, covariance);
  if (goes_back) stride_ *= 0.5;
  last_change_ = change;
  if (stride_ < 1.0) {
    pass.path = path_.towards(pass.path, stride_);
    pass.last.mean = pass.path.stateAt(layout, end);
  }
  // On a crease what is left is what is gone; elsewhere it is the whole step.
  const double left = goes_back ? stride_ : 1.0;
  const Eigen::Vector3d mount_change = left * change.head<kMountSize>();
  const Eigen::Matrix3d mount_covariance = covariance.topLeftCorner<kMountSize, kMountSize>();
  last_step_ = chiSquareOf(StateVector(left * change), covariance);
  last_mount_step_ = chiSquareOf(mount_change, mount_covariance);
  cost_ = cost;
  path_ = pass.path;
  pass_ = std::move(pass);
  return true;
}

/// Whether a step takes most of the one before it back. The cost has a crease where a time offset
/// meets a sample of the wheels' travel, and whole steps go to and fro over it for ever.
bool BatchFit::goesBack(const StateVector& change, const StateMatrix& covariance) const {
  constexpr double kMost = 0.5;
  if (!last_change_) return false;
  const StateVector before = solved(covariance, *last_change_);
  return -change.dot(before) > kMost * last_change_->dot(before);
}

bool BatchFit::hasSettled() const {
  const bool refined_later = stage_ == Stage::kHuber && config_.reject_sigmas > 0.0;
  if (last_step_ < (refined_later ? kSettledHuberStep : kSettledStep)) return true;
  const double limit = refined_later ? kSettledHuberStep : kSettledSlipStep;
  return !weights_.slips().empty() && last_mount_step_ < limit && last_step_ < kNearlySettledStep;
}

/// With other weights than those of the last step.
void BatchFit::weighAnew() {
  cost_ = kInfinity;
  last_change_.reset();
  stride_ = 1.0;
}

/// What to do when the fit has settled.
void BatchFit::nextStage() {
  weighAnew();
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

void BatchFit::judgeInnovations(BatchEstimate& estimate) const {
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

BatchEstimate BatchFit::run() {
  BatchEstimate estimate;
  constexpr int kMostIterations = 60;
  for (int i = 1; i <= kMostIterations && stage_ != Stage::kDone; ++i) {
    endIfCancelled();
    if (!step(i)) {
      if (++failures_ > kMaxFailures || beginning_) break;  // a beginning cannot be damped
      continue;
    }
    const bool free = failures_ == 0;
    failures_ = std::max(0, failures_ - 1);
    near_ = near_ || last_step_ < kNearlySettledStep || i >= kNearAfterIterations;
    if (free && near_ && weights_.giveUpSlip(pass_)) {
      weighAnew();
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

}  // namespace bearing_calibration::core
