// Several lights: the joint fit against what it must be the same as, and who is left out of it.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/calibration/joint_record.h"
#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/judge/lights_agreement.h"
#include "bearing_calibration/solve/rival_mount.h"
#include "support/mount_chi_square.h"
#include "tools/study/default_calibration.h"
#include "tools/study/lights_case.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using testing::mountChiSquare;

SimulatedCase danceWith(int lights, std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = 40.0;
  addLights(simulated, lights, seed);
  simulated.robot.sensor.identifies_lights = true;
  return simulated;
}

BatchEstimate fitFromTruth(const SimulatedCase& simulated, const ObservationRun& run,
                           const std::vector<LightsImage>& images) {
  return BatchEstimator(BatchConfig::leastSquares(simulated.looked_for))
      .estimate(allObservationsOf(simulated, images), trueTrack(simulated, run, images));
}

BatchEstimate fitFromTruth(const SimulatedCase& simulated, const ObservationRun& run) {
  return fitFromTruth(simulated, run, imagesOf(run, run.observations.size()));
}

/// With one light it is the batch of one light, which has been held against a dense solution.
void expectTheSameAsOneLight(SimulatedCase simulated) {
  const ObservationRun run = simulate(simulated);
  const BatchEstimate several = fitFromTruth(simulated, run);
  const std::size_t last = run.observations.size() - 1;
  const BatchEstimate one =
      BatchEstimator(BatchConfig::leastSquares(simulated.looked_for))
          .estimate(run.observations, {run.truth[last], last, trueErrors(simulated)});
  ASSERT_TRUE(several.converged && one.converged);
  // Both stop within a hundredth of a standard deviation of the optimum.
  const CartesianEstimate robot = several.last.cartesian();
  const Vector5 stddev = one.last.cartesian().covariance.diagonal().cwiseSqrt();
  const Vector5 apart = robot.mean - one.last.cartesian().mean;
  EXPECT_LT(apart.cwiseQuotient(stddev).cwiseAbs().maxCoeff(), 0.02);
  const Matrix5 scale = stddev.cwiseInverse().asDiagonal();
  const Matrix5 difference = scale * (robot.covariance - one.last.cartesian().covariance) * scale;
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-3);
  const ErrorVector errors_apart = several.path.errors - one.path.errors;
  EXPECT_LT(errors_apart.cwiseAbs().maxCoeff(), 0.02 * 0.03);
  EXPECT_NEAR(several.chi_square, one.chi_square, 1e-2 * one.chi_square);
}

TEST(JointFit, OfOneLightIsTheBatchOfOneLight) {
  for (std::uint64_t seed : {1, 2, 3}) expectTheSameAsOneLight(danceWith(1, seed));
}

TEST(JointFit, OfOneLightAndAnImperfectRobotIsTheBatchOfOneLight) {
  SimulatedCase simulated = danceWith(1, 4);
  makeImperfect(simulated, {0.03, 0.01, 0.0, 0.0, 0.0, 0.0}, 4);
  simulated.looked_for = usualErrors();
  expectTheSameAsOneLight(simulated);
}

// Two lights of which each is seen in every other image only, at one place, are not one light: but
// the same light twice in each image, with twice the variance, says as much of the mount as once.
TEST(JointFit, TheSameLightTwiceWithTwiceTheVarianceIsThatLightOnce) {
  SimulatedCase simulated = danceWith(1, 5);
  const ObservationRun run = simulate(simulated);
  const BatchEstimate once = fitFromTruth(simulated, run);

  std::vector<LightsImage> images = imagesOf(run, run.observations.size());
  for (LightsImage& image : images) {
    image.lights[0].azimuth_variance_rad2 *= 2.0;
    image.lights[1] = image.lights[0];
  }
  simulated.lights.push_back(simulated.lights.front());
  const BatchEstimate twice = fitFromTruth(simulated, run, images);
  ASSERT_TRUE(once.converged && twice.converged);
  const MountEstimate a = once.last.mount();
  const MountEstimate b = twice.last.mount();
  const Eigen::Vector3d stddev = a.covariance.diagonal().cwiseSqrt();
  EXPECT_LT((a.mean - b.mean).cwiseQuotient(stddev).cwiseAbs().maxCoeff(), 0.02);
  const Eigen::Matrix3d scale = stddev.cwiseInverse().asDiagonal();
  EXPECT_LT((scale * (a.covariance - b.covariance) * scale).cwiseAbs().maxCoeff(), 1e-2);
}

TEST(JointFit, DoesNotDependOnTheLightsOrder) {
  SimulatedCase simulated = danceWith(3, 6);
  const ObservationRun run = simulate(simulated);
  const BatchEstimate fit = fitFromTruth(simulated, run);
  std::vector<LightsImage> images = imagesOf(run, run.observations.size());
  for (LightsImage& image : images) std::swap(image.lights[0], image.lights[2]);
  std::swap(simulated.lights[0], simulated.lights[2]);
  const BatchEstimate swapped = fitFromTruth(simulated, run, images);
  ASSERT_TRUE(fit.converged && swapped.converged);
  constexpr double kRounding = 1e-6;
  EXPECT_LT((fit.last.mount().mean - swapped.last.mount().mean).norm(), kRounding);
  const Vector5 first = fit.last.cartesian(0).mean;
  EXPECT_LT((first - swapped.last.cartesian(2).mean).norm(), kRounding);
}

TEST(JointFit, KeepsTheMeanOfAPrior) {
  constexpr double kNearPerFar_m = -0.63;
  SimulatedCase simulated = danceWith(2, 7);
  simulated.looked_for.setGeometry({0.03, kNearPerFar_m, 0.0});
  const BatchEstimate fit = fitFromTruth(simulated, simulate(simulated));
  ASSERT_TRUE(fit.converged);
  EXPECT_EQ(fit.path.errors(placeOf<MirrorHarmonic>() + MirrorHarmonic::kNearPerFar),
            kNearPerFar_m);
}

/// Two lights, one above and one below a sensor that is tilted.
SimulatedCase tiltedDance(std::uint64_t seed) {
  SimulatedCase simulated = danceWith(2, seed);
  ImperfectRobot how;
  how.tilt_rad = radiansFromDegrees(2.0);
  makeImperfect(simulated, how, seed);
  simulated.robot.sensor.elevation_stddev_rad = radiansFromDegrees(1.0);
  spreadHeights(simulated, 0.4);
  simulated.looked_for.setBlock(SensorTilt::kName, 0.035);
  return simulated;
}

// Mount, tilt and both heights, as uncertain as they are said to be.
TEST(JointFit, FindsTheTiltAndTheHeightOfEachLight) {
  constexpr int kRuns = 24;
  constexpr int kTilt = placeOf<SensorTilt>();
  constexpr int kNumbers = SensorTilt::kHeights + 2;
  double mount_nees = 0.0;
  double tilt_nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedCase simulated = tiltedDance(seed);
    const ObservationRun run = simulate(simulated);
    const BatchEstimate fit = fitFromTruth(simulated, run);
    ASSERT_TRUE(fit.converged) << "seed " << seed;
    mount_nees += mountChiSquare(fit.last.cartesian(), run.truth.back());
    const ErrorEstimate found = fit.last.errors();
    EXPECT_EQ(fit.last.layout.errors, kTilt + kNumbers);
    const Eigen::VectorXd off = (found.mean - trueErrors(simulated)).segment<kNumbers>(kTilt);
    const Eigen::MatrixXd known = found.covariance.block<kNumbers, kNumbers>(kTilt, kTilt);
    tilt_nees += off.dot(known.ldlt().solve(off));
  }
  EXPECT_LT(mount_nees, chiSquareQuantile(0.999, 3.0 * kRuns));
  EXPECT_GT(mount_nees, chiSquareQuantile(0.001, 3.0 * kRuns));
  EXPECT_LT(tilt_nees, chiSquareQuantile(0.999, 1.0 * kNumbers * kRuns));
  EXPECT_GT(tilt_nees, chiSquareQuantile(0.001, 1.0 * kNumbers * kRuns));
}

// A light's height goes where the light goes; one of which nothing is known has none.
TEST(LightsState, HeightsGoWithTheirLights) {
  ErrorPriors priors;
  priors.setBlock(SensorTilt::kName, 0.035);
  StateEstimate three = StateEstimate::zero({errorsInUse(priors, 3), 3});
  for (int i = 0; i < three.layout.size(); ++i) {
    three.mean(i) = i;
    three.covariance(i, i) = 1.0 + i;
  }
  const StateEstimate two = partOf(three, errorsInUse(priors, 2), {2, std::nullopt});
  EXPECT_EQ(two.layout.size(), kMountSize + errorsInUse(priors, 2) + 4);
  const int height = kMountSize + heightAt(0);
  EXPECT_EQ(two.mean(height), kMountSize + heightAt(2));
  EXPECT_EQ(two.covariance(height, height), 1.0 + kMountSize + heightAt(2));
  EXPECT_EQ(two.mean(height + 1), 0.0);
  EXPECT_EQ(two.covariance(height + 1, height + 1), 0.0);
  EXPECT_EQ(two.mean(two.layout.lightAt(0)), three.layout.lightAt(2));
}

/// Two lights that nobody knows, seen by a robot with hardly any noise for many thousand images.
StateEstimate afterManyPreciseBearings(double prior_stddev_m, double bearing_stddev_rad) {
  constexpr int kMotions = 20000;
  constexpr int kMotionsOfOneKind = 25;
  constexpr double kSeparation_m = 0.25;
  constexpr WheelNoise kNoise{1e-12, 0.0};
  StateEstimate start = StateEstimate::zero({0, 2});
  start.mean.tail<4>() << 2.0, 0.0, -1.0, 1.5;
  start.covariance.diagonal().setConstant(prior_stddev_m * prior_stddev_m);
  LiveFilter filter(start);
  for (int i = 0; i < kMotions; ++i) {
    const bool is_straight = i / kMotionsOfOneKind % 2 == 0;
    const WheelDisplacement wheels{is_straight ? 0.02 : -0.02, is_straight ? 0.02 : 0.03};
    const OdometryIncrement motion = append(OdometryIncrement(), wheels, kSeparation_m, kNoise);
    filter.predict(motion);
    for (int light = 0; light < start.layout.lights; ++light) {
      Bearing bearing;
      bearing.azimuth_rad = filter.predictAzimuth({}, light).azimuth_rad;
      bearing.azimuth_variance_rad2 = bearing_stddev_rad * bearing_stddev_rad;
      filter.update(bearing, {}, light);
    }
  }
  return filter.estimate();
}

/// In units of the standard deviations, so that lengths and angles are alike.
void expectACovariance(const StateEstimate& estimate) {
  ASSERT_GT(estimate.covariance.diagonal().minCoeff(), 0.0);
  const StateVector scale = estimate.covariance.diagonal().cwiseSqrt().cwiseInverse();
  const StateMatrix correlation = scale.asDiagonal() * estimate.covariance * scale.asDiagonal();
  EXPECT_LT((correlation - correlation.transpose()).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::SelfAdjointEigenSolver<StateMatrix> solver(correlation, Eigen::EigenvaluesOnly);
  EXPECT_GT(solver.eigenvalues()(0), 0.0);
}

TEST(LightsState, StaysACovarianceOverManyPreciseBearings) {
  expectACovariance(afterManyPreciseBearings(1.0, 1e-2));
  expectACovariance(afterManyPreciseBearings(10.0, 1e-4));
  expectACovariance(afterManyPreciseBearings(10.0, 1e-6));
}

TEST(LightsState, StaysACovarianceWithAMountThatIsKnownPrecisely) {
  StateEstimate estimate = afterManyPreciseBearings(1.0, 1e-2);
  MountEstimate known = estimate.mount();
  known.covariance = Eigen::Vector3d(1e-14, 1e-14, 1e-14).asDiagonal();
  constexpr int kTimes = 1000;
  for (int i = 0; i < kTimes; ++i) {
    addEarlier(lastingPart(known), ErrorPriors(), &estimate);
  }
  expectACovariance(estimate);
}

LandmarkSolution solutionOf(double stddev_m, double bearing_level, double wheel_level) {
  LandmarkSolution solution;
  solution.average = StateEstimate::zero({0, 1});
  solution.average.covariance.diagonal().setConstant(stddev_m * stddev_m);
  solution.noise = {{bearing_level, 0.0}, {wheel_level, 0.0}};
  return solution;
}

TEST(JointRecord, HasTheNoiseOfEachLightsBearingsAndOfTheSurestOnesWheels) {
  const LandmarkSolution vague = solutionOf(0.1, 5.0, 7.0);
  const LandmarkSolution sure = solutionOf(0.01, 2.0, 3.0);
  std::vector<Observation> observations(2);
  for (Observation& observation : observations) {
    observation.azimuth_variance_rad2 = 1.0;
    observation.motion.covariance.setIdentity();
  }
  observations[1].light = 1;
  for (const Observation& observation : withNoise(observations, {&vague, &sure})) {
    EXPECT_EQ(observation.azimuth_variance_rad2, observation.light == 0 ? 25.0 : 4.0);
    EXPECT_EQ(observation.motion.covariance.trace(), 3.0 * 3.0);
  }
}

MountEstimate mountAt(double x_m) {
  MountEstimate mount;
  mount.mean << x_m, 0.0, 0.5;
  mount.covariance = Eigen::Vector3d(1e-6, 1e-6, 1e-4).asDiagonal();  // 1 mm
  return mount;
}

TEST(LightsAgreement, LightsThatSayTheSameAgree) {
  const LightsAgreement agreement = compareLights({mountAt(0.1), mountAt(0.101), mountAt(0.099)});
  EXPECT_EQ(agreement.agreeing.size(), 3U);
  EXPECT_TRUE(agreement.contradicting.empty());
}

TEST(LightsAgreement, TheOneThatContradictsTheOthersIsLeftOut) {
  const LightsAgreement agreement =
      compareLights({mountAt(0.1), mountAt(0.12), mountAt(0.101), mountAt(0.1)});
  EXPECT_EQ(agreement.contradicting, (std::vector<std::size_t>{1}));
  EXPECT_EQ(agreement.agreeing, (std::vector<std::size_t>{0, 2, 3}));
}

// The first and the last of a row contradict each other only: the one that the middle one is
// farther from is left out.
TEST(LightsAgreement, OfTwoThatContradictEachOtherTheFartherIsLeftOut) {
  const LightsAgreement agreement = compareLights({mountAt(0.1), mountAt(0.104), mountAt(0.112)});
  EXPECT_EQ(agreement.contradicting, (std::vector<std::size_t>{2}));
}

// 9.4 mm between two lights of 1 mm each are a chi-square of 44. For the wheels' noise that they
// share it may be twice that of independent ones: 42 for one pair, 53 for the largest of the 15
// pairs of six.
TEST(LightsAgreement, TheMoreLightsTheFartherTwoMayBeApart) {
  const MountEstimate off = mountAt(0.1094);
  EXPECT_EQ(compareLights({mountAt(0.1), off}).contradicting.size(), 1U);
  std::vector<MountEstimate> six(5, mountAt(0.1));
  six.push_back(off);
  EXPECT_TRUE(compareLights(six).contradicting.empty());
}

TEST(LightsAgreement, OfTwoThatDoNotAgreeNobodyKnowsWhichIsRight) {
  const LightsAgreement agreement = compareLights({mountAt(0.1), mountAt(0.12)});
  EXPECT_EQ(agreement.agreeing.size(), agreement.contradicting.size());
}

// Of two independent lights that know the mount equally well the mean is the joint answer: then the
// one's distance from it says what the two say of each other.
TEST(LightsAgreement, ContradictionIsThatOfTheOthers) {
  const MountEstimate one = mountAt(0.1);
  const MountEstimate other = mountAt(0.104);
  MountEstimate joint = mountAt(0.102);
  joint.covariance *= 0.5;
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(contradiction(one, joint), disagreement(one, other), kRounding);
  EXPECT_NEAR(contradiction(other, joint), 16.0 / 2.0, kRounding);  // (4 mm)^2 of 2 (1 mm)^2
}

TEST(LightsAgreement, WhatTheOthersDoNotTellContradictsNothing) {
  MountEstimate joint = mountAt(0.104);
  joint.covariance *= 0.99;
  EXPECT_EQ(contradiction(mountAt(0.1), joint), 0.0);
}

double leastEigenvalue(const Eigen::Matrix3d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix).eigenvalues()(0);
}

// 1 mm and 0.6 degrees; a spread that is wide along x and takes away more than there is along y.
TEST(LeastSpread, OfAnIndefiniteSpreadWidensOnlyWhereItIsPositive) {
  const Eigen::Matrix3d covariance = mountAt(0.0).covariance;
  const Eigen::Matrix3d spread = Eigen::Vector3d(1e-4, -5e-5, 0.0).asDiagonal();
  const Eigen::Matrix3d widened = covariance + leastSpread({spread}, covariance);
  EXPECT_GE(leastEigenvalue(widened), leastEigenvalue(covariance));
  constexpr double kRounding = 1e-15;
  EXPECT_NEAR(widened(0, 0), 1.01e-4, kRounding);
  EXPECT_NEAR(widened(1, 1), 1e-6, kRounding);
  EXPECT_NEAR(widened(2, 2), 1e-4, kRounding);
}

// The trace is that of the yaw, in other units.
TEST(LeastSpread, IsNotHiddenByAnAngleThatIsKnownBetter) {
  const Eigen::Matrix3d covariance = mountAt(0.0).covariance;
  const Eigen::Matrix3d spread = Eigen::Vector3d(1e-5, 0.0, -5e-5).asDiagonal();
  constexpr double kRounding = 1e-15;
  EXPECT_NEAR(leastSpread({spread}, covariance)(0, 0), 1e-5, kRounding);
}

// The first widens x tenfold, the second the yaw by a tenth, though its trace is the larger one.
TEST(LeastSpread, IsMeasuredByTheCovariance) {
  const Eigen::Matrix3d covariance = mountAt(0.0).covariance;
  const Eigen::Matrix3d of_x = Eigen::Vector3d(9e-6, 0.0, 0.0).asDiagonal();
  const Eigen::Matrix3d of_yaw = Eigen::Vector3d(0.0, 0.0, 1e-5).asDiagonal();
  constexpr double kRounding = 1e-15;
  EXPECT_LT((leastSpread({of_x, of_yaw}, covariance) - of_yaw).norm(), kRounding);
}

TEST(MaxLights, HasBounds) {
  CalibratorConfig config = defaultCalibration(paperCase(1).robot.encoders.drive, {1e-6, 0.0});
  EXPECT_TRUE(errorsOf(config).empty());
  for (int wrong : {-1, 0, kMostLights + 1}) {
    config.max_lights = wrong;
    ASSERT_EQ(errorsOf(config).size(), 1U);
    EXPECT_NE(errorsOf(config).front().find("max_lights"), std::string::npos);
  }
}

}  // namespace
}  // namespace bearing_calibration::core
