#include "bearing_calibration/solve/slip_hypotheses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/paper_state.h"

namespace bearing_calibration::core {
namespace {

/// Gain from which one slip more is tried: chance makes about one of them in a record. With the
/// cost of a slip (BatchConfig::slip_gain, 20) it then weighs 1/250.
constexpr double kSuspicion = 9.0;

/// Costs within which a supposition is still open, a thousandth as likely as the best one, and the
/// chi-square of the mount that one right answer in a thousand has.
constexpr double kOpenCost = 14.0;
constexpr double kAgreement = 16.3;
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
      : observations_(observations), estimator_(config), start_(surestStart(batch)), fits_{batch} {}

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

 private:
  /// Fits the best place for what a supposition leaves open, and trusts that place from then on.
  /// @returns whether the next best place is worth a fit
  bool tryBestPlace(SlipHypothesis& supposition) {
    BatchEstimate rival =
        estimator_.estimate(observations_, start_, supposition, fits_.front().beginning);
    if (!rival.converged || rival.cost > fits_.front().cost + kOpenCost) return false;
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
};

/// Mean and covariance of the mixture of all fits.
RobotEstimate mixture(const std::vector<BatchEstimate>& fits, const BatchEstimate& best) {
  using Joint = Gaussian<5 + kErrorCount>;
  const Joint reference = best.robot().joint<kErrorCount>();
  double weights = 0.0;
  decltype(Joint::mean) shift = decltype(Joint::mean)::Zero();  // of the mean, from the best fit's
  decltype(Joint::covariance) spread = decltype(Joint::covariance)::Zero();
  for (const BatchEstimate& fit : fits) {
    const double weight = std::exp(0.5 * (best.cost - fit.cost));
    const Joint joint = fit.robot().joint<kErrorCount>();
    auto difference = (joint.mean - reference.mean).eval();
    difference(CartesianIndex::kSensorYaw) = wrapAngle(difference(CartesianIndex::kSensorYaw));
    weights += weight;
    shift += weight * difference;
    spread += weight * (joint.covariance + difference * difference.transpose());
  }
  shift /= weights;
  Joint average{reference.mean + shift, spread / weights - shift * shift.transpose()};
  double& yaw = average.mean(CartesianIndex::kSensorYaw);
  yaw = wrapAngle(yaw);
  return RobotEstimate::from<kErrorCount>(average);
}

/// What a mount's chi-square would be on the average if the truth were as a rival says.
double chiSquareIf(const MountEstimate& rival, const MountEstimate& mount) {
  const Eigen::LDLT<Eigen::Matrix3d> covariance(mount.covariance);
  Eigen::Vector3d off = rival.mean - mount.mean;
  off.z() = wrapAngle(off.z());
  return off.dot(covariance.solve(off)) + covariance.solve(rival.covariance).trace();
}

bool isDisputed(const std::vector<BatchEstimate>& fits, const BatchEstimate& best,
                const RobotEstimate& average) {
  const MountEstimate mount = mountFromCartesian(average.cartesian);
  return std::any_of(fits.begin(), fits.end(), [&](const BatchEstimate& fit) {
    return fit.cost < best.cost + kOpenCost &&
           chiSquareIf(mountFromCartesian(fit.at_last_observation), mount) > kAgreement;
  });
}

}  // namespace

SlipAverage averageOverSlips(const std::vector<Observation>& observations,
                             const BatchEstimate& batch, const BatchConfig& config) {
  if (config.slip_gain <= 0.0) return {batch, batch, batch.robot()};  // the owner: nothing slips
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
  const RobotEstimate average = mixture(fits, *best);
  return {*best, *leastWith(kDoubt), average, isDisputed(fits, *best, average)};
}

}  // namespace bearing_calibration::core
