// The bench compares like with like: what it measures against finds the same answers.
#include <gtest/gtest.h>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/init/start_candidates.h"
#include "bench/paper_run.h"
#include "bench/reference/ceres_batch.h"
#include "bench/reference/dynamic_ekf.h"

namespace bearing_calibration::core {
namespace {

using reference::CeresAnswer;
using reference::CeresTolerance;

constexpr double kHuber = 2.0;
/// The issue's own: metres and radians of a state, share of a cost.
constexpr double kSameAnswer = 1e-6;
/// Where a robust fit may stop: a hundredth of a standard deviation before its end.
constexpr double kSettledSigmas = 0.01;

std::vector<Observation> firstObservations(std::ptrdiff_t count) {
  return {paperRun().observations.begin(), paperRun().observations.begin() + count};
}

RecordStart startOf(const std::vector<Observation>& observations) {
  return {paperRun().truth[observations.size() - 1], observations.size() - 1};
}

TEST(DynamicEkf, OfAnySizeIsTheFilterOfThisPackage) {
  const CartesianEstimate start{paperRun().truth.front(), 1e-4 * Matrix5::Identity()};
  for (const Eigen::Index states : {5, 15}) {
    LiveFilter filter(StateEstimate::of(start));
    reference::DynamicEkf dynamic(start, states);
    for (std::size_t i = 1; i < paperRun().observations.size(); ++i) {
      const Observation& observation = paperRun().observations[i];
      filter.predict(observation.motion);
      Bearing bearing;
      bearing.azimuth_rad = observation.azimuth_rad;
      bearing.azimuth_variance_rad2 = observation.azimuth_variance_rad2;
      filter.update(bearing);
      dynamic.predict(observation.motion);
      dynamic.update(observation.azimuth_rad, observation.azimuth_variance_rad2);
    }
    const CartesianEstimate estimate = filter.estimate().cartesian();
    constexpr double kRounding = 1e-10;
    EXPECT_LT((dynamic.mean().head<5>() - estimate.mean).norm(), kRounding) << states;
    EXPECT_LT((dynamic.covariance().topLeftCorner<5, 5>() - estimate.covariance).norm(), kRounding)
        << states;
  }
}

TEST(Batch, FindsTheOptimumThatCeresFinds) {
  for (const std::ptrdiff_t count : {100, 300, 1000}) {
    const std::vector<Observation> observations = firstObservations(count);
    const BatchEstimate batch =
        BatchEstimator(reference::costAlone(0.0)).estimate(observations, startOf(observations));
    const CeresAnswer ceres = reference::estimateByCeres(observations, startOf(observations), 0.0,
                                                         CeresTolerance::kTight);
    EXPECT_NEAR(batch.cost / ceres.cost, 1.0, kSameAnswer) << count;
    // The batch ends where its last step was a hundredth of a standard deviation. After 10 s that
    // of the light is so large (decimetres) that the answers may differ by some micrometres.
    if (count == 100) continue;
    EXPECT_LT((batch.last.cartesian().mean - ceres.state).cwiseAbs().maxCoeff(), kSameAnswer)
        << count;
  }
}

TEST(Batch, FindsTheRobustOptimumThatCeresFinds) {
  for (const std::ptrdiff_t count : {100, 300, 1000}) {
    const std::vector<Observation> observations = firstObservations(count);
    const BatchEstimate batch =
        BatchEstimator(reference::costAlone(kHuber)).estimate(observations, startOf(observations));
    const CeresAnswer ceres = reference::estimateByCeres(observations, startOf(observations),
                                                         kHuber, CeresTolerance::kTight);
    EXPECT_NEAR(batch.cost / ceres.cost, 1.0, kSameAnswer) << count;
    const Vector5 sigmas =
        (batch.last.cartesian().mean - ceres.state)
            .cwiseQuotient(batch.last.cartesian().covariance.diagonal().cwiseSqrt());
    EXPECT_LT(sigmas.cwiseAbs().maxCoeff(), kSettledSigmas) << count;
  }
}

// What the bench asks of Ceres with its default tolerances is worth comparing times with.
TEST(Batch, CeresIsAsGoodWithItsDefaultTolerances) {
  const std::vector<Observation> observations = firstObservations(1000);
  for (const double huber_sigmas : {0.0, kHuber}) {
    const auto answer = [&](CeresTolerance tolerance) {
      return reference::estimateByCeres(observations, startOf(observations), huber_sigmas,
                                        tolerance);
    };
    EXPECT_NEAR(answer(CeresTolerance::kDefault).cost / answer(CeresTolerance::kTight).cost, 1.0,
                kSameAnswer);
  }
}

/// Observations of the first 20 s along a path that is taken as exact.
std::vector<PosedObservation> exactPath() {
  std::vector<PosedObservation> observations = poseObservations(firstObservations(200));
  for (PosedObservation& observation : observations) {
    observation.heading_variance_rad2 = 0.0;
    observation.position_variance_m2 = 0.0;
  }
  return observations;
}

TEST(FixedPathFit, FindsTheOptimumThatCeresFinds) {
  const std::vector<PosedObservation> observations = exactPath();
  const Vector5 start =
      paperRun().truth.front() + (Vector5() << 0.1, -0.1, 0.03, 0.03, 0.05).finished();
  const FixedPathFit fit = fitOnFixedPath(observations, start, {0, kHuber});
  const CeresAnswer ceres =
      reference::fitOnFixedPathByCeres(observations, start, kHuber, CeresTolerance::kTight);
  EXPECT_NEAR(fit.cost / ceres.cost, 1.0, kSameAnswer);
}

TEST(Search, FindsTheOptimumThatCeresFindsFromManyStarts) {
  const std::vector<PosedObservation> observations = exactPath();
  constexpr int kStarts = 8;  // as in the bench
  constexpr double kSameWithin_m = 0.1;
  const FixedPathFit found = findConsensus(observations, {0, observations.size()}, 1);
  const CeresAnswer ceres = reference::findStartByCeres(observations, kStarts, kHuber);
  EXPECT_TRUE(isSameMount(found.state_at_first, ceres.state, kSameWithin_m));
  EXPECT_NEAR(found.cost / ceres.cost, 1.0, kSameAnswer);
}

}  // namespace
}  // namespace bearing_calibration::core
