#include "bearing_calibration/solve/smoother.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "bearing_calibration/solve/observability.h"
#include "bearing_calibration/solve/record_weights.h"
#include "support/dense_map.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

/// The paper's dance, thinned so that a dense solution is cheap.
ObservationRun shortRun(std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  simulated.robot.steps_per_bearing = 50;  // two a second
  simulated.duration_s = 20.0;
  // Wheels so noisy that the odometry's share of the problem is not a small one.
  simulated.robot.encoders.noise = {2e-5, 1e-5};
  return simulate(simulated);
}

std::vector<ObservationWeight> plainWeights(const std::vector<Observation>& observations) {
  std::vector<ObservationWeight> weights;
  for (const Observation& observation : observations) {
    weights.push_back({observation.azimuth_variance_rad2, observation.azimuth_variance_rad2});
  }
  return weights;
}

RecordPath pathOf(const ObservationRun& run) {
  RecordPath path;
  path.mount = run.truth.front().tail<3>();
  for (const Vector5& state : run.truth) path.points.push_back({state.head<2>()});
  return path;
}

/// Sum of the squared, standardised innovations: the least cost of the linearised problem.
double linearCost(const SmootherPass& pass, const std::vector<ObservationWeight>& weights) {
  double cost = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const SmoothedObservation& observation = pass.observations[i];
    if (!weights[i].use_bearing) continue;
    cost += observation.azimuth.nis();
  }
  return cost;
}

// Giving up a motion lowers the cost of the linearised problem by the gain that was predicted.
TEST(Smoother, SlipGainIsWhatGivingUpTheMotionTakesOffTheCost) {
  ObservationRun run = shortRun(1);
  // so sharp a sensor that a jump of the light is told in every direction
  for (Observation& observation : run.observations) observation.azimuth_variance_rad2 = 1e-8;
  const std::vector<ObservationWeight> weights = plainWeights(run.observations);
  const SmootherPass pass = smooth(run.observations, weights, pathOf(run), kFreePass);
  const double cost = linearCost(pass, weights);
  for (std::size_t i = 8; i + 8 < run.observations.size(); ++i) {
    const OdometryIncrement motion = run.observations[i].motion;
    run.observations[i].motion.covariance.topLeftCorner<2, 2>() +=
        1e4 * Eigen::Matrix2d::Identity();
    const double without =
        linearCost(smooth(run.observations, weights, pathOf(run), kFreePass), weights);
    run.observations[i].motion = motion;
    EXPECT_NEAR(cost - without, pass.observations[i].slip_gain, 1e-3 * cost) << "observation " << i;
  }
}

TEST(Smoother, AMotionThatIsGivenUpHasNothingMoreToGain) {
  constexpr std::size_t kGivenUp = 12;
  const ObservationRun run = shortRun(1);
  std::vector<ObservationWeight> weights = plainWeights(run.observations);
  weights[kGivenUp].slipped = true;
  const SmootherPass pass = smooth(run.observations, weights, pathOf(run), kFreePass);
  for (std::size_t i = 1; i < run.observations.size(); ++i) {
    EXPECT_EQ(pass.observations[i].slip_gain > 0.0, i != kGivenUp) << "observation " << i;
  }
}

// What was known before it says nothing of the motion to a record's first image.
TEST(Smoother, AFirstMotionHasNothingToGain) {
  const ObservationRun run = shortRun(1);
  StateEstimate known = StateEstimate::zero({errorsInUse(ErrorPriors()), 1});
  known.mean.head<kMountSize>() = run.truth.front().tail<kMountSize>();
  known.mean.tail<2>() = run.truth.front().head<2>();
  known.covariance.diagonal().setConstant(0.01);
  const SmootherPass pass =
      smooth(run.observations, plainWeights(run.observations), pathOf(run), kFreePass, {}, &known);
  EXPECT_EQ(pass.observations[0].slip_gain, 0.0);
  EXPECT_GT(pass.observations[1].slip_gain, 0.0);
}

// Where nothing was known before it, a record begins with its first image.
TEST(Smoother, WhatTheRobotDidBeforeTheFirstImageCountsForNothing) {
  ObservationRun run = shortRun(1);
  const std::vector<ObservationWeight> weights = plainWeights(run.observations);
  const StateEstimate last = smooth(run.observations, weights, pathOf(run), kFreePass).last;
  run.observations[0].motion = append({}, {0.5, 0.7}, 0.25, {1e-3, 1e-3});
  const StateEstimate same = smooth(run.observations, weights, pathOf(run), kFreePass).last;
  EXPECT_EQ(same.mean, last.mean);
  EXPECT_EQ(same.covariance, last.covariance);
}

// A widened variance is what an ordinary elevation has, as if its sensor had said so.
TEST(Smoother, AWidenedElevationIsNoDoubtfulOne) {
  constexpr double kWidening = 5.0;
  constexpr double kVariance_rad2 = 1e-4;
  ErrorPriors priors;
  priors.setBlock(SensorTilt::kName, 0.02);
  const auto passWith = [&](double widening, double variance_rad2) {
    ObservationRun run = shortRun(1);
    std::vector<ObservationWeight> weights = plainWeights(run.observations);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      run.observations[i].elevation = {0.2, variance_rad2};
      weights[i].elevation_widening = widening;
    }
    RecordPath path = pathOf(run);
    path.errors(heightAt(0)) = 0.4;  // at which an elevation tells how far away the light is
    return smooth(run.observations, weights, path, kFreePass, priors);
  };
  const SmootherPass widened = passWith(kWidening, kVariance_rad2);
  const SmootherPass stated = passWith(1.0, kWidening * kVariance_rad2);
  EXPECT_EQ(widened.last.mean, stated.last.mean);
  for (std::size_t i = 1; i < stated.observations.size(); ++i) {
    EXPECT_EQ(widened.observations[i].slip_gain, stated.observations[i].slip_gain) << i;
    EXPECT_EQ(widened.observations[i].mount_displacement.information,
              stated.observations[i].mount_displacement.information)
        << i;
  }
}

// The least cost of a linear problem is that of its innovations.
TEST(Smoother, ItsCostsAddUpToThatOfTheInnovations) {
  const ObservationRun run = shortRun(1);
  const std::vector<ObservationWeight> weights = plainWeights(run.observations);
  StateEstimate known = StateEstimate::zero({errorsInUse(ErrorPriors()), 1});
  known.mean.head<kMountSize>() = run.truth.front().tail<kMountSize>();
  known.mean.tail<2>() = run.truth.front().head<2>();
  known.mean.array() += 0.1;
  known.covariance.diagonal().setConstant(1e-4);
  RecordPath path = pathOf(run);
  SmootherPass pass;
  constexpr int kUntilItHasSettled = 20;
  for (int i = 0; i < kUntilItHasSettled; ++i) {
    pass = smooth(run.observations, weights, path, kFreePass, {}, &known);
    path = pass.path;
  }
  const StateLayout& layout = pass.last.layout;
  double bearings = 0.0;
  for (std::size_t i = 0; i < run.observations.size(); ++i) {
    const Observation& observation = run.observations[i];
    const double expected_rad =
        expectAzimuth(layout, path.stateAt(layout, i), 0, observation.nearby).angle_rad;
    bearings += std::pow(wrapAngle(observation.azimuth_rad - expected_rad), 2) /
                observation.azimuth_variance_rad2;
  }
  EXPECT_GT(pass.beginning_cost, 1.0);
  EXPECT_GT(pass.motion_cost, 1.0);
  EXPECT_NEAR(bearings + pass.motion_cost + pass.beginning_cost, linearCost(pass, weights), 1e-4);
}

TEST(RecordWeights, SayWhetherAnObservationIsLeftOutThatWasNotOrTheOtherWayRound) {
  constexpr std::size_t kOutlier = 7;
  const ObservationRun run = shortRun(1);
  const BatchConfig config;
  RecordWeights weights(run.observations, std::vector<bool>(run.observations.size(), true), config,
                        {});
  SmootherPass pass;
  pass.observations.resize(run.observations.size());
  pass.path = pathOf(run);
  EXPECT_FALSE(weights.rejectOutliers(pass));
  pass.observations[kOutlier].left_out_residual_rad = 1.0;
  EXPECT_TRUE(weights.rejectOutliers(pass));
  EXPECT_FALSE(weights.observations()[kOutlier].use_bearing);
  EXPECT_FALSE(weights.rejectOutliers(pass)) << "it is left out already";
  pass.observations[kOutlier].left_out_residual_rad = 0.0;
  EXPECT_TRUE(weights.rejectOutliers(pass));
  EXPECT_TRUE(weights.observations()[kOutlier].use_bearing);
}

// The residual against all others is the one of a pass that never saw the observation.
TEST(Smoother, LeftOutResidualIsThatOfAPassWithoutTheObservation) {
  const ObservationRun run = shortRun(2);
  std::vector<ObservationWeight> weights = plainWeights(run.observations);
  const SmootherPass pass = smooth(run.observations, weights, pathOf(run), kFreePass);
  // from the fifth observation on: before it, both sides have nothing but the wide prior to go by
  for (std::size_t i = 5; i < run.observations.size(); i += 4) {
    weights[i].use_bearing = false;
    const SmootherPass without = smooth(run.observations, weights, pathOf(run), kFreePass);
    weights[i].use_bearing = true;
    const SmoothedObservation& expected = without.observations[i];
    EXPECT_NEAR(pass.observations[i].left_out_residual_rad, expected.left_out_residual_rad, 1e-6);
    EXPECT_NEAR(pass.observations[i].left_out_variance_rad2, expected.left_out_variance_rad2,
                1e-4 * expected.left_out_variance_rad2 + 1e-9);
    const AzimuthModel model = azimuthFromCartesian(run.truth[i]);
    const double linear = wrapAngle(run.observations[i].azimuth_rad - model.azimuth_rad) -
                          (model.J_azimuth_state * (without.path.state(i) - run.truth[i])).value();
    EXPECT_NEAR(expected.left_out_residual_rad, linear, 1e-6);
  }
}

// A dense Gauss-Newton over mount, light and the noise of every motion, which shares nothing with
// the smoother but the bearing's formula, has the same optimum and the same covariance.
TEST(BatchEstimator, AgreesWithADenseMaximumOfThePosterior) {
  const BatchConfig plain = BatchConfig::leastSquares();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ObservationRun run = shortRun(seed);
    const BatchEstimate batch = BatchEstimator(plain).estimate(
        run.observations, {run.truth.back(), run.observations.size() - 1});
    ASSERT_TRUE(batch.converged);
    const CartesianEstimate dense = testing::maximisePosterior(run.observations, run.truth.front());
    const Vector5 stddev = dense.covariance.diagonal().cwiseSqrt();
    Vector5 difference = batch.last.cartesian().mean - dense.mean;
    difference(4) = wrapAngle(difference(4));
    EXPECT_LT((difference.array() / stddev.array()).abs().maxCoeff(), 0.01) << "seed " << seed;
    const Vector5 ratio =
        batch.last.cartesian().covariance.diagonal().cwiseQuotient(dense.covariance.diagonal());
    EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 0.01)
        << "seed " << seed << ": " << ratio.transpose();
  }
}

BatchConfig plainWithErrors() {
  BatchConfig config = BatchConfig::leastSquares();
  config.errors.setBlock(TimeOffset::kName, 0.1);
  config.errors.setBlock(WheelScales::kName, 0.03);
  config.errors.setBlock(WheelSeparation::kName, 0.01);
  return config;
}

/// A record of which the first part has been given away for what it says.
struct CutRecord {
  std::vector<Observation> rest;
  RecordBeginning beginning;
};

CutRecord cutAfter(std::size_t count, const ObservationRun& run, const BatchEstimate& fit,
                   const BatchEstimator& estimator) {
  return {{run.observations.begin() + static_cast<std::ptrdiff_t>(count), run.observations.end()},
          {estimator.knownAt(count - 1, run.observations, fit), 0.0, 0.0, {}}};
}

// What is linear in the past loses nothing by being kept as one Gaussian: the rest of a record
// with it says what the whole record says, of mount, light and robot.
TEST(BatchEstimator, ACutRecordSaysWhatTheWholeOneSays) {
  const BatchEstimator estimator(plainWithErrors());
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedCase simulated = paperCase(seed);
    simulated.duration_s = 60.0;
    const ObservationRun run = simulate(simulated);
    const std::size_t last = run.observations.size() - 1;
    const BatchEstimate whole = estimator.estimate(run.observations, {run.truth[last], last});
    ASSERT_TRUE(whole.converged);
    for (const std::size_t count : {last / 3, last / 2}) {
      const CutRecord cut = cutAfter(count, run, whole, estimator);
      const BatchEstimate rest =
          estimator.estimate(cut.rest, {run.truth[last], cut.rest.size() - 1}, {}, cut.beginning);
      ASSERT_TRUE(rest.converged);
      const StateVector stddev = whole.last.covariance.diagonal().cwiseSqrt();
      StateVector difference = rest.last.mean - whole.last.mean;
      difference(kMountSize - 1) = wrapAngle(difference(kMountSize - 1));
      EXPECT_LT((difference.array() / stddev.array()).abs().maxCoeff(), 0.02) << "seed " << seed;
      const StateVector ratio =
          rest.last.covariance.diagonal().cwiseQuotient(whole.last.covariance.diagonal());
      EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 0.02) << "seed " << seed;
      EXPECT_NEAR(rest.path.mount.x(), whole.path.mount.x(), 0.02 * stddev(0));
      const std::size_t gains = whole.mount_displacements.size() - 5;
      EXPECT_NEAR(testDisplacement(rest.mount_displacements[gains - count]).gain,
                  testDisplacement(whole.mount_displacements[gains]).gain, 0.1);
    }
  }
}

/// What an estimate knows of the metric scale beyond the priors of the wheels' errors, as seen from
/// a state.
double learntScale(const StateEstimate& estimate, const StateVector& at,
                   const ErrorPriors& priors) {
  // mount, time offset, three lengths that are relative to one, light
  const Eigen::Vector3d lengths = Eigen::Vector3d::Ones() + at.segment<3>(4);
  Eigen::Matrix<double, 9, 1> growth;
  growth << at(0), at(1), 0.0, 0.0, lengths, at(7), at(8);
  const Eigen::Vector3d prior = priors.stddev.segment<3>(1).cwiseAbs2().cwiseInverse();
  return growth.dot(estimate.covariance.ldlt().solve(growth)) - lengths.cwiseAbs2().dot(prior);
}

/// How the priors pull at the metric scale, as seen from a state: nothing else does, so that it is
/// 0 where they are content.
double pullOnScale(const StateEstimate& estimate, const StateVector& at,
                   const ErrorPriors& priors) {
  const Eigen::Array3d lengths = 1.0 + at.segment<3>(4).array();
  const Eigen::Array3d off = estimate.mean.segment<3>(4) - priors.mean.segment<3>(1);
  return (lengths * off / priors.stddev.segment<3>(1).array().square()).sum();
}

// Lights, mount and wheels could be any size together, whatever the record. One linearisation knows
// that; seen from another place, it seems to have learnt the scale.
TEST(MetricScale, IsKnownByThePriorsAlone) {
  const ErrorPriors priors = plainWithErrors().errors;
  SimulatedCase simulated = paperCase(1);
  simulated.duration_s = 60.0;
  const ObservationRun run = simulate(simulated);
  const std::size_t last = run.observations.size() - 1;
  const StateEstimate fit =
      BatchEstimator(plainWithErrors()).estimate(run.observations, {run.truth[last], last}).last;
  const double prior = priors.stddev.segment<3>(1).cwiseAbs2().cwiseInverse().sum();
  EXPECT_LT(std::abs(learntScale(fit, fit.mean, priors)), 1e-5 * prior);
  const StateVector stddev = fit.covariance.diagonal().cwiseSqrt();
  const StateEstimate same = withoutLearntScale(fit, fit.mean, priors);
  EXPECT_LT(((same.mean - fit.mean).array() / stddev.array()).abs().maxCoeff(), 1e-2);
  EXPECT_TRUE(same.covariance.isApprox(fit.covariance, 1e-2));

  StateVector other = fit.mean;
  other(0) += stddev(0);
  EXPECT_GT(learntScale(fit, other, priors), 1.0);  // a standard deviation squared, or more
  const StateEstimate known = withoutLearntScale(fit, other, priors);
  EXPECT_LT(std::abs(learntScale(known, other, priors)), 1e-9 * prior);
  EXPECT_GE(known.covariance(0, 0), fit.covariance(0, 0));
  StateEstimate strained = fit;
  strained.mean.segment<3>(4).array() += 0.01;  // all lengths, which the data have nothing against
  EXPECT_GT(pullOnScale(strained, other, priors), 1.0);
  const StateEstimate eased = withoutLearntScale(strained, other, priors);
  EXPECT_LT(std::abs(pullOnScale(eased, other, priors)), 1e-6);

  ErrorPriors measured = priors;  // a length that is known for certain tells the scale
  measured.setBlock(WheelSeparation::kName, 0.0);
  EXPECT_EQ(withoutLearntScale(fit, other, measured).mean, fit.mean);
}

// An estimate that weighs what was known beforehand by L, of a variance that is w times as large in
// truth, is off by P (J + w L) P, with the information J of the data.
TEST(MetricScale, IsAsUncertainAsLengthsAreOffWhatWasKnownOfThem) {
  constexpr double kOneInFour = 2.773;  // chi-square of two degrees, from a table
  const ErrorPriors priors = plainWithErrors().errors;
  SimulatedCase simulated = paperCase(1);
  simulated.duration_s = 60.0;
  const ObservationRun run = simulate(simulated);
  const std::size_t last = run.observations.size() - 1;
  StateEstimate fit =
      BatchEstimator(plainWithErrors()).estimate(run.observations, {run.truth[last], last}).last;
  const Eigen::Array3d stddev = priors.stddev.segment<3>(1);
  fit.mean.segment<3>(4) = Eigen::Array3d(0.7, 0.7, -1.3) * stddev;  // chi-square 2.67
  EXPECT_EQ(withDoubtOfLengths(fit, priors).covariance, fit.covariance);

  fit.mean.segment<3>(4) = Eigen::Array3d(2.0, 2.0, -4.0) * stddev;
  const double doubt = doubtOfLengths(fit.errors(), priors);
  EXPECT_NEAR(doubt, 4.0 + 4.0 + 16.0 - kOneInFour, 1e-3);
  Eigen::MatrixXd information = Eigen::MatrixXd(fit.covariance).inverse();
  information.diagonal().segment<3>(4).array() += doubt / stddev.square();
  const Eigen::MatrixXd expected = fit.covariance * information * fit.covariance;
  EXPECT_TRUE(withDoubtOfLengths(fit, priors).covariance.isApprox(expected, 1e-9));
}

TEST(BatchEstimator, RefusesABeginningOfOtherLightsOrErrors) {
  const ObservationRun run = shortRun(1);
  const BatchEstimator estimator(plainWithErrors());
  RecordBeginning beginning;
  beginning.known.layout = {errorsInUse(ErrorPriors()), 1};
  EXPECT_THROW(estimator.estimate(run.observations, {run.truth.front(), 0}, {}, beginning),
               std::invalid_argument);
  beginning.known.layout = {errorsInUse(plainWithErrors().errors), 2};
  EXPECT_THROW(estimator.estimate(run.observations, {run.truth.front(), 0}, {}, beginning),
               std::invalid_argument);
}

TEST(BatchEstimator, FindsTheSlipAndTheOutliers) {
  SimulatedCase simulated = paperCase(4);
  simulated.duration_s = 60.0;
  simulated.robot.faults.slips = {{{30.0, 0.4}, WheelSlip::Wheel::kLeft, 0.6}};
  ObservationRun run = simulate(simulated);
  const std::size_t outliers[] = {100, 101, 333, 480};
  for (std::size_t i : outliers) run.observations[i].azimuth_rad += 0.5;
  const BatchEstimate batch =
      BatchEstimator(BatchConfig())
          .estimate(run.observations, {run.truth.back(), run.observations.size() - 1});
  ASSERT_TRUE(batch.converged);
  ASSERT_EQ(batch.slips.size(), 1U);
  EXPECT_NEAR(static_cast<double>(batch.slips.front()), 302.0, 5.0);
  for (std::size_t i : outliers) {
    EXPECT_NE(std::find(batch.rejected.begin(), batch.rejected.end(), i), batch.rejected.end())
        << "observation " << i << " was not rejected";
  }
  EXPECT_LT(batch.rejected.size(), 15U);
  // the mount, the light, and where the light is after the slip
  EXPECT_EQ(batch.degrees_of_freedom,
            static_cast<int>(run.observations.size() - batch.rejected.size()) - 3 - 2 - 2);
}

TEST(BatchEstimator, WidensForCorrelatedNoise) {
  SimulatedCase simulated = paperCase(5);
  simulated.robot.sensor.correlation = 0.5;
  const ObservationRun run = simulate(simulated);
  const BatchEstimate batch =
      BatchEstimator(BatchConfig())
          .estimate(run.observations, {run.truth.back(), run.observations.size() - 1});
  ASSERT_TRUE(batch.converged);
  EXPECT_NEAR(batch.correlation, 0.5, 0.1);
  BatchConfig unaware;
  unaware.widen_for_correlation = false;
  const BatchEstimate narrow = BatchEstimator(unaware).estimate(
      run.observations, {run.truth.back(), run.observations.size() - 1});
  // (1 + 0.5) / (1 - 0.5) = 3 for the bearings' share of the variance
  const double ratio =
      batch.last.cartesian().covariance(4, 4) / narrow.last.cartesian().covariance(4, 4);
  EXPECT_GT(ratio, 1.5);
  EXPECT_LT(ratio, 3.5);
}

TEST(BatchEstimator, RefusesAStartAtNoObservationAndABadVariance) {
  const BatchEstimator estimator{BatchConfig()};
  EXPECT_THROW(estimator.estimate({}, RecordStart()), std::invalid_argument);
  ObservationRun run = shortRun(1);
  run.observations[3].azimuth_variance_rad2 = 0.0;
  EXPECT_THROW(estimator.estimate(run.observations, {run.truth.front(), 0}), std::invalid_argument);
}

// The paper's settings, second trajectory: the bound that model.md's sources give, to its
// digits.
TEST(CramerRaoBound, IsTheKnownOneAtThePapersSettings) {
  struct Row {
    double time_s, yaw_deg, rho_mm;
  };
  for (const Row& row : {Row{20.0, 1.3, 4.5}, Row{40.0, 0.49, 2.4}, Row{100.0, 0.28, 1.6}}) {
    SimulatedCase simulated = paperCase(1);
    simulated.duration_s = row.time_s;
    const ObservationRun run = simulate(simulated);
    std::vector<Eigen::Vector2d> lights;
    lights.reserve(run.truth.size());  // a sanitizer sees what is read behind the last
    for (const Vector5& state : run.truth) lights.push_back(state.head<2>());
    const Matrix5 bound =
        cramerRaoBound(run.observations, lights, run.truth.back().tail<3>()).cartesian().covariance;
    const Eigen::Vector2d along = run.truth.back().segment<2>(2).normalized();
    const double rho_m = std::sqrt(along.dot(bound.block<2, 2>(2, 2) * along));
    constexpr double kDigits = 0.16;  // two digits, and a period of the dance more or less
    EXPECT_NEAR(1e3 * rho_m, row.rho_mm, kDigits * row.rho_mm);
    EXPECT_NEAR(degreesFromRadians(std::sqrt(bound(4, 4))), row.yaw_deg, kDigits * row.yaw_deg);
  }
}

}  // namespace
}  // namespace bearing_calibration::core
