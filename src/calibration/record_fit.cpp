#include "bearing_calibration/calibration/record_fit.h"

#include <algorithm>

#include "bearing_calibration/init/other_answers.h"
#include "bearing_calibration/init/start_candidates.h"
#include "bearing_calibration/solve/mount_displacement.h"

namespace bearing_calibration::core {

void RecordFit::beginAt(const RecordStart& start, const std::vector<Observation>& observations) {
  settled_ = {observations[start.observation].stamp, start};
}

std::optional<SlipAverage> RecordFit::fit(const std::vector<Observation>& observations,
                                          const StateEstimate& running,
                                          const std::optional<RecordBeginning>& beginning) {
  const BatchEstimate batch = fitOnce(observations, running, beginning);
  if (!batch.hasSettled(config_.min_inlier_fraction)) return std::nullopt;
  SlipAverage settled = averageOverSlips(observations, batch, config_.batch);
  // What was given away rests on the answer that stood when no rival was open.
  if (!beginning) other_minimum_ = otherMinimum(observations, settled);
  settled.rival.offer(other_minimum_.gap, other_minimum_.mount);
  settled.rival.minima = other_minimum_.minima;
  beginAt(surestStart(settled.best), observations);
  return settled;
}

BatchEstimate RecordFit::fitOnce(const std::vector<Observation>& observations,
                                 const StateEstimate& running,
                                 const std::optional<RecordBeginning>& beginning) const {
  if (settled_) {
    const auto there = std::find_if(
        observations.begin(), observations.end(),
        [this](const Observation& observation) { return observation.stamp == settled_->stamp; });
    if (there != observations.end()) {  // it has neither been thinned out nor given away
      RecordStart start = settled_->start;
      start.observation = static_cast<std::size_t>(there - observations.begin());
      BatchEstimate batch = batch_.estimate(observations, start, {}, beginning);
      if (batch.hasSettled(config_.min_inlier_fraction)) return batch;
    }
  }
  return batch_.estimate(observations, {running, observations.size() - 1}, {}, beginning);
}

/// The best other minimum that is another mount.
RivalMount RecordFit::otherMinimum(const std::vector<Observation>& observations,
                                   const SlipAverage& settled) const {
  const MountEstimate mount = settled.estimate.mount();
  RivalMount rival;
  rival.minima = kYawsAround;
  for (const OtherAnswer& other : findOtherAnswers(observations, settled.best, config_)) {
    if (isAnotherMount({other.mount, Eigen::Matrix3d::Zero()}, mount))
      rival.offer(other.gap, other.mount);
  }
  return rival;
}

std::size_t RecordFit::cutOf(const SlipAverage& settled, std::size_t most) {
  if (settled.rival.isOpen()) return 0;
  const std::vector<ObservationWeight>& weights = settled.trusting.weights;
  std::size_t count = most;
  // not within a slip, which nobody could look for any more
  while (count > 1 && (weights[count - 1].slipped || weights[count].slipped)) --count;
  return count > 1 ? count : 0;
}

RecordPart RecordFit::oldestPart(const std::vector<Observation>& observations,
                                 const BatchEstimate& fit, std::size_t count,
                                 const std::optional<StateEstimate>& average) const {
  return {count, batch_.knownAt(count - 1, observations, fit, average),
          scatterOf(fit.mount_displacements, 0, count)};
}

}  // namespace bearing_calibration::core
