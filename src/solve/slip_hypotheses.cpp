#include "bearing_calibration/solve/slip_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "bearing_calibration/filter/paper_filter.h"

namespace bearing_calibration::core {
namespace {

/// Gain from which one slip more is tried: chance makes about one of them in a record. With the
/// cost of a slip (BatchConfig::slip_gain, 20) it then weighs 1/250.
constexpr double kSuspicion = 9.0;

/// What a slip must gain beyond its cost to be beyond doubt. A jump that may be anything within
/// some decimetres fits what chance does, too: that it is told to a centimetre in two directions
/// counts for 2 ln 30^2 = 14 against it, of which a fit's own cost of a slip has a part.
constexpr double kDoubt = 10.0;

SlipHypothesis withOneMore(const BatchEstimate& batch) {
  SlipHypothesis one_more;
  one_more.given_up = batch.slips;
  one_more.least_gain = kSuspicion;
  one_more.most_further = 1;
  return one_more;
}

/// The fit's slips without one of them, which is looked for elsewhere.
SlipHypothesis withSlipElsewhere(const BatchEstimate& batch, std::size_t slip) {
  SlipHypothesis elsewhere;
  for (std::size_t other : batch.slips) {
    if (other != slip) elsewhere.given_up.push_back(other);
  }
  elsewhere.trusted = {slip};
  elsewhere.at_its_cost = true;
  return elsewhere;
}

/// The fits of all suppositions that cannot be ruled out, beside the one that they rival.
class Rivals {
 public:
  Rivals(const std::vector<Observation>& observations, const BatchEstimate& batch,
         const BatchConfig& config)
      : observations_(observations),
        estimator_(config.weighedAs(batch)),
        start_(surestStart(batch)),
        fits_{batch},
        answers_{answerOf(batch)} {}

  /// Tries all suppositions in turn, again and again while they go on finding something.
  void findAll(std::vector<SlipHypothesis> suppositions) {
    constexpr std::size_t kMostFits = 6;
    std::size_t tried = 0;
    while (!suppositions.empty()) {
      std::vector<SlipHypothesis> still_open;
      for (SlipHypothesis& supposition : suppositions) {
        if (tried++ == kMostFits) return;
        if (tryBestPlace(supposition)) still_open.push_back(std::move(supposition));
      }
      suppositions = std::move(still_open);
    }
  }

  const std::vector<BatchEstimate>& fits() const { return fits_; }

  /// The best of all that were tried, ruled out or not, which gives another mount.
  /// @param cost  of the best one
  RivalMount rivalOf(const MountEstimate& average, double cost) const {
    RivalMount rival;
    rival.slips = static_cast<int>(answers_.size()) - 1;
    for (const Answer& answer : answers_) {
      if (isAnotherMount(answer.mount, average)) {
        rival.offer(0.5 * (answer.cost - cost), answer.mount.mean);
      }
    }
    return rival;
  }

 private:
  struct Answer {
    double cost;
    MountEstimate mount;
  };
  static Answer answerOf(const BatchEstimate& fit) { return {fit.cost, fit.last.mount()}; }

  /// Fits the best place for what a supposition leaves open, and trusts that place from then on.
  /// @returns whether the next best place is worth a fit
  bool tryBestPlace(SlipHypothesis& supposition) {
    BatchEstimate rival =
        estimator_.estimate(observations_, start_, supposition, fits_.front().beginning);
    if (!rival.converged) return false;
    answers_.push_back(answerOf(rival));
    if (rival.cost > fits_.front().cost + 2.0 * kOpenGap) return false;
    const std::size_t trusted = supposition.trusted.size();
    const std::vector<std::size_t>& given_up = supposition.given_up;
    std::copy_if(
        rival.slips.begin(), rival.slips.end(), std::back_inserter(supposition.trusted),
        [&](std::size_t slip) { return std::count(given_up.begin(), given_up.end(), slip) == 0; });
    if (isNew(rival)) fits_.push_back(std::move(rival));
    return supposition.trusted.size() > trusted;
  }

  bool isNew(const BatchEstimate& rival) const {
    return std::none_of(fits_.begin(), fits_.end(),
                        [&](const BatchEstimate& fit) { return fit.slips == rival.slips; });
  }

  const std::vector<Observation>& observations_;
  BatchEstimator estimator_;
  RecordStart start_;
  std::vector<BatchEstimate> fits_;  ///< the first is the one that is rivalled
  std::vector<Answer> answers_;      ///< of every fit, ruled out or not
};

/// Mean and covariance of the mixture of all fits.
StateEstimate mixture(const std::vector<BatchEstimate>& fits, const BatchEstimate& best) {
  StateEstimate average = best.last;
  double weights = 0.0;
  StateVector shift = StateVector::Zero(average.layout.size());  // of the mean, from the best fit's
  average.covariance.setZero();
  for (const BatchEstimate& fit : fits) {
    const double weight = std::exp(0.5 * (best.cost - fit.cost));
    StateVector difference = fit.last.mean - best.last.mean;
    difference.head<kMountSize>() = mountDifference(fit.last.mount().mean, best.last.mount().mean);
    weights += weight;
    shift += weight * difference;
    average.covariance += weight * (fit.last.covariance + difference * difference.transpose());
  }
  shift /= weights;
  average.mean += shift;
  average.covariance = (average.covariance / weights - shift * shift.transpose()).eval();
  average.wrapYaw();
  return average;
}

}  // namespace

SlipAverage averageOverSlips(const std::vector<Observation>& observations,
                             const BatchEstimate& batch, const BatchConfig& config) {
  if (config.slip_gain <= 0.0) return {batch, batch, batch.last, {}};  // nothing slips
  std::vector<SlipHypothesis> suppositions;
  if (batch.suspicion > kSuspicion) suppositions.push_back(withOneMore(batch));
  for (std::size_t slip : batch.slips) suppositions.push_back(withSlipElsewhere(batch, slip));
  Rivals rivals(observations, batch, config);
  rivals.findAll(std::move(suppositions));
  const std::vector<BatchEstimate>& fits = rivals.fits();
  const auto leastWith = [&fits](double doubt) {
    const auto costOf = [doubt](const BatchEstimate& fit) {
      return fit.cost + doubt * static_cast<double>(fit.slips.size());
    };
    return std::min_element(
        fits.begin(), fits.end(),
        [&](const BatchEstimate& a, const BatchEstimate& b) { return costOf(a) < costOf(b); });
  };
  const auto best = leastWith(0.0);
  const StateEstimate average = mixture(fits, *best);
  return {*best, *leastWith(kDoubt), average, rivals.rivalOf(average.mount(), best->cost)};
}

}  // namespace bearing_calibration::core
