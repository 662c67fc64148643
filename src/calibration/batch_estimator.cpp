#include "bearing_calibration/calibration/batch_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "bearing_calibration/calibration/cartesian_smoother.h"
#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration {
namespace {

constexpr int kStateSize = 5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A fit has settled when its last step, squared over its covariance, is below this: a hundredth of
/// a standard deviation; while Huber's weights are still to be replaced, a tenth.
constexpr double kSettledStep = 1e-4;
constexpr double kSettledHuberStep = 1e-2;
/// After a slip the light's distance may be so uncertain that it never settles as well, since the
/// noise of the slip grows with it: then the mount must settle to a thirtieth of a standard
/// deviation, and the whole state to a half.
constexpr double kSettledSlipStep = 1e-3;
constexpr double kNearlySettledStep = 0.25;
/// Rejections may change so often before they are frozen: sights at the very limit could go in and
/// out for ever.
constexpr int kMaxRejectionRounds = 6;
constexpr int kMaxFailures = 6;
/// A slip lasts: what is found is its most telling moment, and motions this near are not believed
/// either.
constexpr Duration kSlipReach = std::chrono::milliseconds(250);
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

/// Lag-1 correlation of the standardised innovations of good sights; 0 where insignificant.
double innovationCorrelation(const SmootherPass& pass, const std::vector<SightWeight>& weights) {
  // Clipped, so that neither a slip's after-effects nor an outlier decide.
  constexpr double kClip = 2.5;
  constexpr double kSignificant = 2.0;  // standard deviations, 1/sqrt(n) each, of white innovations
  constexpr double kLargest = 0.9;      // beyond it the sights say nothing about their number
  double products = 0.0;
  double squares = 0.0;
  int pairs = 0;
  double last = 0.0;
  bool has_last = false;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!weights[i].use_bearing) {
      has_last = false;
      continue;
    }
    const SmoothedSight& sight = pass.sights[i];
    const double standardised =
        std::clamp(sight.innovation_rad / std::sqrt(sight.innovation_variance_rad2), -kClip, kClip);
    if (has_last) {
      products += last * standardised;
      squares += standardised * standardised;
      ++pairs;
    }
    last = standardised;
    has_last = true;
  }
  if (pairs == 0 || squares <= 0.0) return 0.0;
  const double correlation = products / squares;
  return correlation > kSignificant / std::sqrt(pairs) ? std::min(correlation, kLargest) : 0.0;
}

/// One fit of one record, from the start to the end of its iterations. Slips are looked for as soon
/// as the fit is near; then the weights go from Huber's to plain ones without the outliers.
class Fit {
 public:
  Fit(const std::vector<Sight>& sights, const RecordStart& start, const BatchConfig& config)
      : config_(config), sights_(sights) {
    LightTrack track = trackLight(sights, start);
    for (std::size_t i = 0; i < sights.size(); ++i) {
      path_.push_back({track.states[i], Eigen::Vector3d::Zero()});
      const double variance = sights[i].azimuth_variance_rad2;
      const bool use = track.is_plausible[i] || config_.reject_sigmas <= 0.0;
      weights_.push_back({variance, variance, use});
    }
    if (config_.huber_sigmas > 0.0) weighByHuber();
  }

  BatchEstimate run();

 private:
  enum class Stage { kHuber, kRejecting, kWidening, kDone };

  bool step();
  bool hasSettled() const;
  bool findSlip();
  bool isInsideSlip(std::size_t i) const;
  void nextStage();
  bool rejectOutliers();
  void weighByHuber();
  void weighPlainly();
  bool widenForCorrelation();
  double residual(std::size_t i, const std::vector<PathPoint>& path) const;
  double bearingCost(const std::vector<PathPoint>& path) const;
  double totalCost() const;
  void judgeInnovations(BatchEstimate& estimate) const;

  const BatchConfig& config_;
  const std::vector<Sight>& sights_;
  std::vector<PathPoint> path_;
  std::vector<SightWeight> weights_;
  SmootherPass pass_;
  SmootherPass settled_;  ///< before the variances were widened: what the fit is judged by
  Stage stage_ = Stage::kHuber;
  double widening_ = 1.0;  ///< of all bearing variances, for their correlation
  double correlation_ = 0.0;
  double cost_ = kInfinity;       ///< of path_, by the present weights; not known yet
  double last_step_ = kInfinity;  ///< of the state at the last sight, squared over its covariance
  double last_mount_step_ = kInfinity;
  bool near_ = false;  ///< so near the end that slips can be told
  int failures_ = 0;
  int rejection_rounds_ = 0;
  std::vector<std::size_t> slips_;
};

double Fit::residual(std::size_t i, const std::vector<PathPoint>& path) const {
  return wrapAngle(sights_[i].azimuth_rad - azimuthFromCartesian(path[i].state).azimuth_rad);
}

/// Huber's cost, or the plain one, of the bearings in use.
double Fit::bearingCost(const std::vector<PathPoint>& path) const {
  const bool huber = stage_ == Stage::kHuber && config_.huber_sigmas > 0.0;
  double cost = 0.0;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    if (!weights_[i].use_bearing) continue;
    const double sigmas =
        std::abs(residual(i, path)) / std::sqrt(widening_ * sights_[i].azimuth_variance_rad2);
    cost += huber && sigmas > config_.huber_sigmas
                ? config_.huber_sigmas * (2.0 * sigmas - config_.huber_sigmas)
                : sigmas * sigmas;
  }
  return cost;
}

void Fit::weighByHuber() {
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    const double variance = widening_ * sights_[i].azimuth_variance_rad2;
    const double sigmas = std::abs(residual(i, path_)) / std::sqrt(variance);
    weights_[i].sensor_variance_rad2 = variance;
    weights_[i].bearing_variance_rad2 = variance * std::max(1.0, sigmas / config_.huber_sigmas);
  }
}

void Fit::weighPlainly() {
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    weights_[i].sensor_variance_rad2 = widening_ * sights_[i].azimuth_variance_rad2;
    weights_[i].bearing_variance_rad2 = weights_[i].sensor_variance_rad2;
  }
}

/// One Gauss-Newton step; false when it would not lower the cost.
bool Fit::step() {
  SmootherPass pass = smooth(sights_, weights_, path_, dampedPrior(failures_));
  std::vector<PathPoint> path;
  path.reserve(sights_.size());
  for (const SmoothedSight& sight : pass.sights) path.push_back(sight.point);
  const double cost = pass.motion_cost + bearingCost(path);
  // The lever of the heading noise, and with it the cost of one and the same motion, changes from
  // step to step: only a cost that clearly rises is a reason to hold back.
  constexpr double kTolerance = 1.0;
  constexpr double kRelativeTolerance = 0.2;
  if (!(cost <= cost_ * (1.0 + kRelativeTolerance) + kTolerance)) return false;
  const Vector5 change = path.back().state - path_.back().state;
  const Eigen::Vector3d mount_change = change.tail<3>();
  const Eigen::Matrix3d mount_covariance = pass.last.covariance.bottomRightCorner<3, 3>();
  last_step_ = change.dot(pass.last.covariance.ldlt().solve(change));
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
  return !slips_.empty() && last_mount_step_ < limit && last_step_ < kNearlySettledStep;
}

/// Gives up the motion that the bearings contradict most, if they do so clearly.
bool Fit::findSlip() {
  if (config_.slip_gain <= 0.0 || static_cast<int>(slips_.size()) >= config_.max_slips)
    return false;
  const auto worst = std::max_element(
      pass_.sights.begin(), pass_.sights.end(),
      [](const SmoothedSight& a, const SmoothedSight& b) { return a.slip_gain < b.slip_gain; });
  if (worst->slip_gain < config_.slip_gain) return false;
  const auto at = static_cast<std::size_t>(worst - pass_.sights.begin());
  for (std::size_t i = 1; i < sights_.size(); ++i) {
    const Duration apart =
        i < at ? sights_[at].stamp - sights_[i].stamp : sights_[i].stamp - sights_[at].stamp;
    if (apart <= kSlipReach) weights_[i].slipped = true;
  }
  weights_[at].slipped = true;
  slips_.push_back(at);
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    if (isInsideSlip(i)) weights_[i].use_bearing = false;
  }
  return true;
}

/// A sight between two motions that are not believed only says where the light was at that moment.
bool Fit::isInsideSlip(std::size_t i) const {
  return weights_[i].slipped && i + 1 < weights_.size() && weights_[i + 1].slipped;
}

/// Decides anew which sights are left out; true when that changed.
bool Fit::rejectOutliers() {
  if (++rejection_rounds_ > kMaxRejectionRounds) return false;
  bool changed = false;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    const SmoothedSight& sight = pass_.sights[i];
    const double variance = sight.left_out_variance_rad2 + sights_[i].azimuth_variance_rad2;
    const bool use =
        !isInsideSlip(i) && sight.left_out_residual_rad * sight.left_out_residual_rad <=
                                config_.reject_sigmas * config_.reject_sigmas * variance;
    changed = changed || use != weights_[i].use_bearing;
    weights_[i].use_bearing = use;
  }
  return changed;
}

bool Fit::widenForCorrelation() {
  correlation_ = innovationCorrelation(pass_, weights_);
  // n bearings whose noise is a first-order autoregression are worth this times fewer white ones.
  widening_ = (1.0 + correlation_) / (1.0 - correlation_);
  weighPlainly();
  return correlation_ > 0.0;
}

/// What to do when the fit has settled.
void Fit::nextStage() {
  cost_ = kInfinity;
  if (stage_ == Stage::kHuber) {
    if (config_.reject_sigmas > 0.0) {
      stage_ = Stage::kRejecting;
      weighPlainly();
      rejectOutliers();
      return;
    }
    stage_ = Stage::kWidening;
  } else if (stage_ == Stage::kRejecting) {
    if (rejectOutliers()) return;
    stage_ = Stage::kWidening;
  } else {
    stage_ = Stage::kDone;
    return;
  }
  if (!config_.widen_for_correlation) {
    stage_ = Stage::kDone;
    return;
  }
  settled_ = pass_;
  if (!widenForCorrelation()) stage_ = Stage::kDone;
}

double Fit::totalCost() const {
  const double reject_cost = config_.reject_sigmas * config_.reject_sigmas;
  const auto left_out = std::count_if(weights_.begin(), weights_.end(),
                                      [](const SightWeight& w) { return !w.use_bearing; });
  return pass_.motion_cost + bearingCost(path_) + reject_cost * static_cast<double>(left_out) +
         config_.slip_gain * static_cast<double>(slips_.size());
}

void Fit::judgeInnovations(BatchEstimate& estimate) const {
  const SmootherPass& pass = settled_.sights.empty() ? pass_ : settled_;
  int used = 0;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    estimate.nis.push_back(std::numeric_limits<double>::quiet_NaN());
    if (!weights_[i].use_bearing) {
      estimate.rejected.push_back(i);
      continue;
    }
    ++used;
    const SmoothedSight& sight = pass.sights[i];
    estimate.nis.back() =
        sight.innovation_rad * sight.innovation_rad / sight.innovation_variance_rad2;
    estimate.chi_square += estimate.nis.back();
  }
  estimate.degrees_of_freedom =
      std::max(0, used - kStateSize - 2 * static_cast<int>(slips_.size()));
  estimate.slips = slips_;
  std::sort(estimate.slips.begin(), estimate.slips.end());
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
    if (free && near_ && findSlip()) {
      cost_ = kInfinity;
    } else if (free && hasSettled()) {
      nextStage();
    } else if (stage_ == Stage::kHuber && config_.huber_sigmas > 0.0) {
      weighByHuber();
    }
  }
  if (pass_.sights.empty()) return estimate;
  estimate.converged = stage_ == Stage::kDone && pass_.last.mean.allFinite();
  estimate.at_last_sight = pass_.last;
  estimate.at_last_sight.mean(CartesianIndex::kSensorYaw) =
      wrapAngle(estimate.at_last_sight.sensorYaw());
  estimate.cost = totalCost();
  estimate.correlation = correlation_;
  judgeInnovations(estimate);
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
  require.that(max_slips >= 0,
               "batch/max_slips must not be negative, but is " + std::to_string(max_slips));
  return require.errors();
}

double BatchEstimate::inlierFraction() const {
  if (nis.empty()) return 0.0;
  return 1.0 - static_cast<double>(rejected.size()) / static_cast<double>(nis.size());
}

BatchEstimator::BatchEstimator(const BatchConfig& config) : config_(validated(config)) {}

BatchEstimate BatchEstimator::estimate(const std::vector<Sight>& sights,
                                       const RecordStart& start) const {
  if (start.sight >= sights.size()) {
    throw std::invalid_argument("the start of a batch estimate is not at one of its sights");
  }
  for (const Sight& sight : sights) {
    if (!(sight.azimuth_variance_rad2 > 0.0)) {
      throw std::invalid_argument("azimuth variance " +
                                  std::to_string(sight.azimuth_variance_rad2) +
                                  " rad^2 is not positive");
    }
  }
  return Fit(sights, start, config_).run();
}

}  // namespace bearing_calibration
