// The bench compares like with like: what it measures against finds the same answers.
#include <gtest/gtest.h>

#include "bearing_calibration/calibration/start_candidates.h"
#include "bearing_calibration/filter/mount_filter.h"
#include "bench/paper_run.h"
#include "bench/reference/ceres_batch.h"
#include "bench/reference/dynamic_ekf.h"

namespace bearing_calibration {
namespace {

using reference::CeresAnswer;
using reference::CeresTolerance;

constexpr double kHuber = 2.0;
/// The issue's own: metres and radians of a state, share of a cost.
constexpr double kSameAnswer = 1e-6;
/// Where a robust fit may stop: a hundredth of a standard deviation before its end.
constexpr double kSettledSigmas = 0.01;

std::vector<Sight> firstSights(std::ptrdiff_t count) {
  return {paperRun().sights.begin(), paperRun().sights.begin() + count};
}

RecordStart startOf(const std::vector<Sight>& sights) {
  return {paperRun().truth[sights.size() - 1], sights.size() - 1};
}

TEST(DynamicEkf, OfAnySizeIsTheFilterOfThisPackage) {
  const CartesianEstimate start{paperRun().truth.front(), 1e-4 * Matrix5::Identity()};
  const auto filter = makeCartesianFilter(start);
  for (const Eigen::Index states : {5, 15}) {
    filter->restart({start, {}});
    reference::DynamicEkf dynamic(start, states);
    for (std::size_t i = 1; i < paperRun().sights.size(); ++i) {
      const Sight& sight = paperRun().sights[i];
      filter->predict(sight.motion);
      filter->update(sight.azimuth_rad, sight.azimuth_variance_rad2);
      dynamic.predict(sight.motion);
      dynamic.update(sight.azimuth_rad, sight.azimuth_variance_rad2);
    }
    const CartesianEstimate estimate = filter->cartesian();
    constexpr double kRounding = 1e-10;
    EXPECT_LT((dynamic.mean().head<5>() - estimate.mean).norm(), kRounding) << states;
    EXPECT_LT((dynamic.covariance().topLeftCorner<5, 5>() - estimate.covariance).norm(), kRounding)
        << states;
  }
}

TEST(Batch, FindsTheOptimumThatCeresFinds) {
  for (const std::ptrdiff_t count : {100, 300, 1000}) {
    const std::vector<Sight> sights = firstSights(count);
    const BatchEstimate batch =
        BatchEstimator(reference::costAlone(0.0)).estimate(sights, startOf(sights));
    const CeresAnswer ceres =
        reference::estimateByCeres(sights, startOf(sights), 0.0, CeresTolerance::kTight);
    EXPECT_NEAR(batch.cost / ceres.cost, 1.0, kSameAnswer) << count;
    // The batch ends where its last step was a hundredth of a standard deviation. After 10 s that
    // of the light is so large (decimetres) that the answers may differ by some micrometres.
    if (count == 100) continue;
    EXPECT_LT((batch.at_last_sight.mean - ceres.state).cwiseAbs().maxCoeff(), kSameAnswer) << count;
  }
}

TEST(Batch, FindsTheRobustOptimumThatCeresFinds) {
  for (const std::ptrdiff_t count : {100, 300, 1000}) {
    const std::vector<Sight> sights = firstSights(count);
    const BatchEstimate batch =
        BatchEstimator(reference::costAlone(kHuber)).estimate(sights, startOf(sights));
    const CeresAnswer ceres =
        reference::estimateByCeres(sights, startOf(sights), kHuber, CeresTolerance::kTight);
    EXPECT_NEAR(batch.cost / ceres.cost, 1.0, kSameAnswer) << count;
    const Vector5 sigmas =
        (batch.at_last_sight.mean - ceres.state)
            .cwiseQuotient(batch.at_last_sight.covariance.diagonal().cwiseSqrt());
    EXPECT_LT(sigmas.cwiseAbs().maxCoeff(), kSettledSigmas) << count;
  }
}

// What the bench asks of Ceres with its default tolerances is worth comparing times with.
TEST(Batch, CeresIsAsGoodWithItsDefaultTolerances) {
  const std::vector<Sight> sights = firstSights(1000);
  for (const double huber_sigmas : {0.0, kHuber}) {
    const auto answer = [&](CeresTolerance tolerance) {
      return reference::estimateByCeres(sights, startOf(sights), huber_sigmas, tolerance);
    };
    EXPECT_NEAR(answer(CeresTolerance::kDefault).cost / answer(CeresTolerance::kTight).cost, 1.0,
                kSameAnswer);
  }
}

/// Sights of the first 20 s along a path that is taken as exact.
std::vector<PosedSight> exactPath() {
  std::vector<PosedSight> sights = poseSights(firstSights(200));
  for (PosedSight& sight : sights) {
    sight.heading_variance_rad2 = 0.0;
    sight.position_variance_m2 = 0.0;
  }
  return sights;
}

TEST(FixedPathFit, FindsTheOptimumThatCeresFinds) {
  const std::vector<PosedSight> sights = exactPath();
  const Vector5 start =
      paperRun().truth.front() + (Vector5() << 0.1, -0.1, 0.03, 0.03, 0.05).finished();
  const FixedPathFit fit = fitOnFixedPath(sights, start, {0, kHuber});
  const CeresAnswer ceres =
      reference::fitOnFixedPathByCeres(sights, start, kHuber, CeresTolerance::kTight);
  EXPECT_NEAR(fit.cost / ceres.cost, 1.0, kSameAnswer);
}

TEST(Search, FindsTheOptimumThatCeresFindsFromManyStarts) {
  const std::vector<PosedSight> sights = exactPath();
  constexpr int kStarts = 8;  // as in the bench
  constexpr double kSameWithin_m = 0.1;
  const FixedPathFit found = findConsensus(sights, {0, sights.size()}, 1);
  const CeresAnswer ceres = reference::findStartByCeres(sights, kStarts, kHuber);
  EXPECT_TRUE(isSameMount(found.state_at_first, ceres.state, kSameWithin_m));
  EXPECT_NEAR(found.cost / ceres.cost, 1.0, kSameAnswer);
}

}  // namespace
}  // namespace bearing_calibration
