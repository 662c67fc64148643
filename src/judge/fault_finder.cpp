#include "bearing_calibration/judge/fault_finder.h"

#include <optional>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/record/observation_change.h"
#include "bearing_calibration/record/observation_path.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {
namespace {

/// Enough to tell whether a hypothesis fits, and quick.
constexpr std::size_t kObservationsOfDiagnosis = 200;

/// A record with one fault undone, and how well a start from nothing then fits.
struct Hypothesis {
  Diagnosis diagnosis;
  StartAttempt attempt;

  double misfit() const { return attempt.chi_square / std::max(1, attempt.degrees_of_freedom); }
};

class FaultSearch {
 public:
  FaultSearch(const std::vector<Observation>& observations, double wheel_separation_m,
              const InitializerConfig& config)
      : observations_(observations),
        separation_m_(wheel_separation_m),
        config_(config),
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
    if (!best_) {
      tryLatency();
      tryProportions();
    }
    // what a robot without it explains as well, or another fault better, is not named
    if (best_) return best_->attempt.ready() ? best_->diagnosis : Diagnosis{};
    return lightMoved() && !isNoisier() ? Diagnosis{Fault::kLightMoved, 0.0} : Diagnosis{};
  }

 private:
  static constexpr double kCleanShare =
      0.9;  ///< of the observations that a true hypothesis explains

  void try_(const Diagnosis& diagnosis, const std::vector<Observation>& observations) {
    Hypothesis hypothesis{diagnosis,
                          findStart(thinned(observations, kObservationsOfDiagnosis), config_)};
    if (!hypothesis.attempt.fits()) return;
    if (!best_ || hypothesis.misfit() < best_->misfit()) best_ = hypothesis;
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
    for (double late_s : {-0.1, -0.05, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3}) {
      try_({Fault::kLate, late_s}, withEarlierBearings(observations_, late_s, separation_m_));
    }
  }

  void tryProportions() {
    for (double factor : {0.85, 0.9, 0.94, 0.97, 1.03, 1.06, 1.1, 1.15}) {
      tryWheels({Fault::kLeftRadius, factor}, Eigen::Vector2d(factor, 1.0).asDiagonal(), 1.0);
      tryWheels({Fault::kRightRadius, factor}, Eigen::Vector2d(1.0, factor).asDiagonal(), 1.0);
      tryWheels({Fault::kSeparation, factor}, Eigen::Matrix2d::Identity(), factor);
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

  /// Whether more noise than is stated makes one record likelier than two with a light each.
  bool isNoisier() const {
    if (!noise_.any()) return false;
    InitializerConfig config = config_;
    config.noise = noise_;
    const auto attempt = [&](const std::vector<Observation>& observations) {
      return findStart(observations, config, noiseToBeginWith(observations, noise_));
    };
    const StartAttempt both = attempt(observations_);
    return both.fits() &&
           both.noise_cost < attempt(firstHalf()).noise_cost + attempt(secondHalf()).noise_cost;
  }

  const std::vector<Observation>& observations_;
  double separation_m_;
  InitializerConfig config_;
  NoisePriors noise_;               ///< of what is stated
  std::optional<Hypothesis> best_;  ///< of those that explain the record
};

}  // namespace

Diagnosis findFault(const std::vector<Observation>& observations, double wheel_separation_m,
                    const InitializerConfig& config) {
  return FaultSearch(observations, wheel_separation_m, config).run();
}

}  // namespace bearing_calibration::core
