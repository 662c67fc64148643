#include "bearing_calibration/judge/fault_finder.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/record/observation_path.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {
namespace {

/// Enough to tell whether a hypothesis fits, and quick.
constexpr std::size_t kObservationsOfDiagnosis = 200;

/// A record with one fault undone, and how well a start from nothing then fits.
struct Hypothesis {
  Diagnosis diagnosis;
  std::vector<Observation> observations;
  StartAttempt attempt;

  double misfit() const { return attempt.chi_square / std::max(1, attempt.degrees_of_freedom); }
};

class FaultSearch {
 public:
  FaultSearch(const std::vector<Observation>& observations, double wheel_separation_m,
              const InitializerConfig& config, const ErrorPriors& known)
      : observations_(observations),
        separation_m_(wheel_separation_m),
        config_(config),
        known_(known),
        noise_(config.noise) {
    // Slips, outliers and noise would let a wrong hypothesis off: they are what it has to explain.
    config_.batch.slip_gain = 0.0;
    config_.min_inlier_fraction = kCleanShare;
    config_.noise = {};
    config_.search_errors = false;  // each hypothesis is a robot of its own already
  }

  Diagnosis run() {
    try_({Fault::kNone, 0.0}, observations_);
    if (!best_) trySigns();
    // what a robot without it explains as well, or another fault better, is not named
    if (best_) return best_->attempt.ready() ? best_->diagnosis : Diagnosis{};
    tryLatency();
    tryProportions();
    if (best_) {
      const bool is_it = best_->attempt.ready() && isLikelierThanNoise({best_->observations});
      return is_it ? best_->diagnosis : Diagnosis{};
    }
    return lightMoved() && isLikelierThanNoise({firstHalf(), secondHalf()})
               ? Diagnosis{Fault::kLightMoved, 0.0}
               : Diagnosis{};
  }

 private:
  static constexpr double kCleanShare =
      0.9;  ///< of the observations that a true hypothesis explains

  void try_(const Diagnosis& diagnosis, std::vector<Observation> observations) {
    const StartAttempt attempt =
        findStart(thinned(observations, kObservationsOfDiagnosis), config_);
    if (!attempt.fits()) return;
    Hypothesis hypothesis{diagnosis, std::move(observations), attempt};
    if (!best_ || hypothesis.misfit() < best_->misfit()) best_ = std::move(hypothesis);
  }

  void tryWheels(const Diagnosis& diagnosis, const Eigen::Matrix2d& wheels_from_wheels,
                 double separation_factor) {
    try_(diagnosis, withOtherWheels(observations_, wheels_from_wheels, separation_m_,
                                    separation_factor * separation_m_));
  }

  void trySigns() {
    try_({Fault::kMirrored, 0.0}, mirrored(observations_));
    tryWheels({Fault::kLeftReversed, 0.0}, Eigen::Vector2d(-1.0, 1.0).asDiagonal(), 1.0);
    tryWheels({Fault::kRightReversed, 0.0}, Eigen::Vector2d(1.0, -1.0).asDiagonal(), 1.0);
  }

  void tryLatency() {
    if (known_.areEstimated<TimeOffset>()) return;
    for (double late_s : {-0.1, -0.05, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3}) {
      try_({Fault::kLate, late_s}, withEarlierBearings(observations_, late_s, separation_m_));
    }
  }

  void tryProportions() {
    const auto trySeparation = [this](double factor) {
      if (known_.areEstimated<WheelSeparation>()) return;
      tryWheels({Fault::kSeparation, factor}, Eigen::Matrix2d::Identity(), factor);
    };
    // a diameter for a radius, or other edges of the ticks counted
    for (double factor : {0.25, 0.5, 2.0, 4.0}) trySeparation(factor);
    for (double factor : {0.85, 0.9, 0.94, 0.97, 1.03, 1.06, 1.1, 1.15}) {
      if (!known_.areEstimated<WheelScales>()) {
        tryWheels({Fault::kLeftRadius, factor}, Eigen::Vector2d(factor, 1.0).asDiagonal(), 1.0);
        tryWheels({Fault::kRightRadius, factor}, Eigen::Vector2d(1.0, factor).asDiagonal(), 1.0);
      }
      trySeparation(factor);
    }
  }

  std::vector<Observation> firstHalf() const { return {observations_.begin(), middle()}; }
  std::vector<Observation> secondHalf() const { return {middle(), observations_.end()}; }
  std::vector<Observation>::const_iterator middle() const {
    return observations_.begin() + static_cast<std::ptrdiff_t>(observations_.size() / 2);
  }

  /// Each half fits by itself and gives the same mount, though both together do not.
  bool lightMoved() const {
    const StartAttempt first = findStart(firstHalf(), config_);
    const StartAttempt second = findStart(secondHalf(), config_);
    constexpr double kSameMount = 0.999;
    return first.ready() && second.ready() &&
           disagreement(first.estimate.mount(), second.estimate.mount()) <
               chiSquareQuantile(kSameMount, 3.0);
  }

  /// Whether the record with a fault undone, in one part or in two with a light each, is likelier
  /// than the record as it is with more noise than is stated.
  bool isLikelierThanNoise(const std::vector<std::vector<Observation>>& undone) const {
    constexpr double kEvidence = 5.0;  // of a logarithm: 150 times as likely
    if (!noise_.any()) return true;
    InitializerConfig config = config_;
    config.noise = noise_;
    const auto attempt = [&](const std::vector<Observation>& observations) {
      return findStart(observations, config, noiseToBeginWith(observations, noise_));
    };
    const StartAttempt noisy = attempt(observations_);
    double cost = kEvidence;
    for (const std::vector<Observation>& part : undone) cost += attempt(part).noise_cost;
    return !noisy.fits() || cost < noisy.noise_cost;
  }

  const std::vector<Observation>& observations_;
  double separation_m_;
  InitializerConfig config_;
  const ErrorPriors& known_;
  NoisePriors noise_;               ///< of what is stated
  std::optional<Hypothesis> best_;  ///< of those that explain the record
};

}  // namespace

Diagnosis findFault(const std::vector<Observation>& observations, double wheel_separation_m,
                    const InitializerConfig& config, const ErrorPriors& known) {
  return FaultSearch(observations, wheel_separation_m, config, known).run();
}

Diagnosis unlikelyWheels(const ErrorEstimate& estimate, const ErrorPriors& priors) {
  constexpr double kMostDoubt = 36.0;  // a chi-square: 6 standard deviations
  if (doubtOfLengths(estimate, priors) <= kMostDoubt) return {};
  const double left = 1.0 + estimate.mean(placeOf<WheelScales>());
  const double right = 1.0 + estimate.mean(placeOf<WheelScales>() + 1);
  const double separation = 1.0 + estimate.mean(placeOf<WheelSeparation>());
  const Diagnosis ratio{Fault::kRightRadius, right / left};
  const Diagnosis turns{Fault::kSeparation, separation / (0.5 * (left + right))};
  return std::abs(std::log(ratio.size)) > std::abs(std::log(turns.size)) ? ratio : turns;
}

}  // namespace bearing_calibration::core
