// What the calibrator is compared with is implemented as well as its theory promises.
#include "tools/study/comparison.h"

#include <gtest/gtest.h>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/solve/batch_estimator.h"

namespace bearing_calibration::core {
namespace {

constexpr int kRuns = 30;
constexpr double kFalseAlarm = 1e-3;

/// The first setting: the paper's world with noise as stated.
const std::vector<ComparedRun>& paperRuns() {
  static const std::vector<ComparedRun> kAll = [] {
    std::vector<ComparedRun> runs;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
      runs.push_back(comparedRun(comparisonSettings().front().make(seed), seed));
    }
    return runs;
  }();
  return kAll;
}

/// The sum of their chi-squares is that of so many independent mounts.
void expectConsistent(Snapshot (*estimator)(const ComparedRun& run)) {
  double chi_square = 0.0;
  for (const ComparedRun& run : paperRuns()) chi_square += estimator(run).mountChiSquare();
  constexpr double kDegrees = 3.0 * kRuns;
  EXPECT_LT(chi_square, chiSquareQuantile(1.0 - kFalseAlarm, kDegrees));
  EXPECT_GT(chi_square, chiSquareQuantile(kFalseAlarm, kDegrees));
}

TEST(Comparison, PlainFilterWithAGoodStartIsConsistent) { expectConsistent(runPaperFilter); }

TEST(Comparison, FilterWithAKnownLightIsConsistent) { expectConsistent(runKnownLight); }

TEST(Comparison, FilterBankIsConsistent) { expectConsistent(runFilterBank); }

// More is known, and from the same start: the mount is more certain.
TEST(Comparison, AKnownLightMakesTheMountMoreCertain) {
  for (const ComparedRun& run : paperRuns()) {
    const Matrix5 known = runKnownLight(run).covariance;
    const Matrix5 unknown = runPaperFilter(run).covariance;
    for (int i = CartesianIndex::kSensorX; i <= CartesianIndex::kSensorYaw; ++i) {
      EXPECT_LT(known(i, i), unknown(i, i)) << run.seed;
    }
  }
}

// Ceres from a start that is off, the package's batch from the truth: one optimum, one covariance.
TEST(Comparison, CeresIsTheLeastSquaresOfThePackage) {
  constexpr double kSameSigmas = 0.05;
  constexpr double kSameCovariance = 0.01;  // Ceres stops by its default tolerances
  const ComparedRun& run = paperRuns().front();
  const std::size_t last = run.observations.size() - 1;
  const BatchEstimate batch = BatchEstimator(BatchConfig::leastSquares())
                                  .estimate(run.observations, {run.truth.truth[last], last});
  ASSERT_TRUE(batch.converged);
  const Snapshot ceres = runCeres(run);
  ASSERT_TRUE(ceres.has_estimate);
  const MountEstimate mount = batch.last.mount();
  const Eigen::Vector3d off =
      mountDifference(ceres.error.tail<3>() + run.truth.truth[last].tail<3>(), mount.mean);
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  EXPECT_LT(off.cwiseQuotient(stddev).cwiseAbs().maxCoeff(), kSameSigmas);
  const Eigen::Matrix3d difference = ceres.covariance.bottomRightCorner<3, 3>() - mount.covariance;
  EXPECT_LT(difference.cwiseQuotient(stddev * stddev.transpose()).cwiseAbs().maxCoeff(),
            kSameCovariance);
}

}  // namespace
}  // namespace bearing_calibration::core
