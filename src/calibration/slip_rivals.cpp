#include "bearing_calibration/calibration/slip_rivals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

/// Gain from which one slip more is tried: chance makes about one of them in a record. With the
/// cost of a slip (BatchConfig::slip_gain, 20) it then weighs 1/250.
constexpr double kSuspicion = 9.0;

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
  return elsewhere;
}

std::vector<BatchEstimate> findRivals(const std::vector<Sight>& sights, const BatchEstimate& batch,
                                      const BatchConfig& config) {
  std::vector<SlipHypothesis> suppositions;
  if (batch.suspicion > kSuspicion) suppositions.push_back(withOneMore(batch));
  for (std::size_t slip : batch.slips) suppositions.push_back(withSlipElsewhere(batch, slip));

  const BatchEstimator estimator(config);
  const RecordStart start = surestStart(batch);
  std::vector<BatchEstimate> rivals;
  for (const SlipHypothesis& supposition : suppositions) {
    BatchEstimate rival = estimator.estimate(sights, start, supposition);
    if (rival.converged && rival.slips != batch.slips) rivals.push_back(std::move(rival));
  }
  return rivals;
}

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

}  // namespace

SlipAverage averageOverSlips(const std::vector<Sight>& sights, const BatchEstimate& batch,
                             const BatchConfig& config) {
  if (config.slip_gain <= 0.0) return {batch, batch.robot()};  // the owner: nothing slips
  std::vector<BatchEstimate> fits = findRivals(sights, batch, config);
  fits.push_back(batch);
  const auto best = std::min_element(
      fits.begin(), fits.end(),
      [&config](const BatchEstimate& a, const BatchEstimate& b) { return a.cost < b.cost; });
  return {*best, mixture(fits, *best)};
}

}  // namespace bearing_calibration
