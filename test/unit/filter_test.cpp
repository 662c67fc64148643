#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <random>

#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/filter/paper_filter.h"
#include "bearing_calibration/track/association.h"
#include "bearing_calibration/track/mount_tracker.h"
#include "support/numerical_jacobian.h"

namespace bearing_calibration::core {
namespace {

Matrix5 randomCovariance(std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  Matrix5 root;
  for (int i = 0; i < root.size(); ++i) root(i) = normal(*random);
  return root * root.transpose() + 0.1 * Matrix5::Identity();
}

// The information form is an independent way to the same answer: P^-1 = P0^-1 + H^T H / R.
TEST(ScalarUpdate, AgreesWithTheInformationForm) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    StateEstimate prior{{0, 1}, Vector5::Zero(), randomCovariance(&random)};
    StateRow H(5);
    for (int j = 0; j < 5; ++j) {
      prior.mean(j) = normal(random);
      H(j) = normal(random);
    }
    constexpr double kVariance = 0.3;
    const double residual = normal(random);
    StateEstimate posterior = prior;
    apply(prepareUpdate(H, residual, kVariance, prior), &posterior);
    const Matrix5 information = prior.covariance.inverse() + H.transpose() * H / kVariance;
    const Vector5 mean = prior.mean + information.inverse() * H.transpose() * residual / kVariance;
    EXPECT_LT((posterior.covariance * information - Matrix5::Identity()).norm(), 1e-9);
    EXPECT_LT((posterior.mean - mean).norm(), 1e-9);
  }
}

/// How many of 100 covariances of huge and tiny entries stay positive under updates by numbers of
/// this variance.
template <class Update>
int positiveOf100(double variance, const Update& update) {
  int positive = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    StateEstimate state = StateEstimate::zero({0, 1});
    state.covariance.diagonal() << 1e6, 1e6, 1.0, 1.0, 1e-6;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    bool is_positive = true;
    for (int i = 0; i < 100; ++i) {
      StateRow H(5);
      for (int j = 0; j < 5; ++j) H(j) = normal(random);
      update(prepareUpdate(H, 0.0, variance, state), &state);
      EXPECT_EQ((state.covariance - state.covariance.transpose()).norm(), 0.0);
      is_positive = is_positive && state.covariance.ldlt().vectorD().minCoeff() >= 0.0;
    }
    positive += is_positive ? 1 : 0;
  }
  return positive;
}

// 14 powers of ten lie between the variances here, 16 are all that a double has.
TEST(ScalarUpdate, KeepsAnIllConditionedCovariancePositive) {
  EXPECT_EQ(positiveOf100(1e-8, apply), 100);
}

// Where the numbers end, the Joseph form fails less often than P - K H P.
TEST(ScalarUpdate, KeepsMoreOfThemPositiveThanTheShortForm) {
  const auto shortForm = [](const ScalarUpdate& update, StateEstimate* state) {
    state->covariance -= update.innovation.variance * update.gain * update.gain.transpose();
    symmetrise(&state->covariance);
  };
  EXPECT_LT(100 - positiveOf100(1e-10, apply), (100 - positiveOf100(1e-10, shortForm)) / 2);
}

TEST(Innovation, IsWrapped) {
  const AzimuthPrediction prediction{kPi - 0.01, 1e-4};
  const Innovation innovation = prediction.innovationOf(-kPi + 0.01, 3e-4);
  EXPECT_NEAR(innovation.residual, 0.02, 1e-12);
  EXPECT_NEAR(innovation.nis(), 0.02 * 0.02 / 4e-4, 1e-9);
}

Bearing bearingOf(double azimuth_rad, double variance_rad2) {
  Bearing bearing;
  bearing.azimuth_rad = azimuth_rad;
  bearing.azimuth_variance_rad2 = variance_rad2;
  return bearing;
}

TEST(LiveFilter, BothParametrisationsAgreeOnAGoodStart) {
  CartesianEstimate start;
  start.mean << 1.5, 0.5, 0.1, -0.05, 1.0;
  start.covariance.diagonal() << 1e-6, 1e-6, 1e-7, 1e-7, 1e-6;
  LiveFilter cartesian(StateEstimate::of(start));
  LiveFilter paper(StateEstimate::of(start), LiveFilter::Parametrisation::kPaper);
  std::mt19937_64 random(4);
  std::normal_distribution<double> noise(0.0, 1e-3);
  OdometryIncrement motion;
  for (int i = 0; i < 50; ++i) {
    motion = append({}, {0.01, 0.02 + 0.001 * i}, 0.25, {1e-6, 0.0});
    for (LiveFilter* filter : {&cartesian, &paper}) filter->predict(motion);
    const double azimuth = cartesian.predictAzimuth().azimuth_rad + noise(random);
    EXPECT_NEAR(paper.predictAzimuth().azimuth_rad, cartesian.predictAzimuth().azimuth_rad, 1e-4);
    for (LiveFilter* filter : {&cartesian, &paper}) filter->update(bearingOf(azimuth, 1e-6));
  }
  const StateVector difference = cartesian.estimate().mean - paper.estimate().mean;
  const StateVector stddev = cartesian.estimate().covariance.diagonal().cwiseSqrt();
  EXPECT_LT((difference.array() / stddev.array()).abs().maxCoeff(), 0.1);
}

// A sensor that is known but for its distance: the direction to it has no variance.
TEST(PaperEstimate, HasNoNegativeVarianceWhereRoundingIsLargest) {
  for (double direction_rad = -3.0; direction_rad < 3.0; direction_rad += 0.1) {
    const Eigen::Vector2d direction(std::cos(direction_rad), std::sin(direction_rad));
    CartesianEstimate estimate;
    estimate.mean << 1.5, 0.6, 1e-6 * direction, 0.5;
    Vector5 known;
    known << 0.03, 0.03, 1e-4 * direction, 2e-3;
    estimate.covariance = known * known.transpose();
    const Matrix5 covariance = paperFromCartesian(estimate).covariance;
    EXPECT_GE(covariance.diagonal().minCoeff(), 0.0) << direction_rad;
    EXPECT_LT(covariance(PaperIndex::kPhi, PaperIndex::kPhi), 1e-6) << direction_rad;
  }
}

TEST(PaperFilter, GivesANegativeRhoItsUsualName) {
  CartesianEstimate start;
  start.mean << 2.0, 0.0, 0.01, 0.0, 0.5;
  start.covariance = 1e-2 * Matrix5::Identity();
  PaperFilter filter(paperFromCartesian(start));
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.3);
  for (int i = 0; i < 200; ++i) {  // bearings at random drive rho to either side of zero
    filter.update(filter.expectAzimuth().azimuth_rad + noise(random), 1e-2);
    EXPECT_GE(filter.estimate().mean(PaperIndex::kRho), 0.0);
    EXPECT_GE(filter.estimate().mean(PaperIndex::kDistance), 0.0);
  }
}

// ---- the light ----

TEST(PlaceLight, CovarianceIsThatOfTheNumericalJacobian) {
  MountEstimate mount;
  mount.mean << 0.1, -0.2, 2.0;
  mount.covariance << 4e-4, 1e-4, 2e-5, 1e-4, 9e-4, -3e-5, 2e-5, -3e-5, 1e-4;
  const LightDistance distance{1.5, 0.3};
  constexpr double kAzimuth = -1.0;
  constexpr double kVariance = 2e-4;
  const auto place = [](const Vector5& v) {  // by x, y, yaw, distance, azimuth
    MountEstimate m;
    m.mean = v.head<3>();
    return placeLight(m, {v(3), 0.0}, v(4), 0.0).mean;
  };
  Vector5 at;
  at << mount.mean, distance.mean_m, kAzimuth;
  const Matrix5 J = testing::numericalJacobian<5, 5>(place, at);
  Matrix5 known = Matrix5::Zero();
  known.topLeftCorner<3, 3>() = mount.covariance;
  known(3, 3) = distance.stddev_m * distance.stddev_m;
  known(4, 4) = kVariance;
  const CartesianEstimate placed = placeLight(mount, distance, kAzimuth, kVariance);
  EXPECT_LT((placed.covariance - J * known * J.transpose()).norm(), 1e-9);
  // the light is seen where it was placed
  EXPECT_NEAR(azimuthFromCartesian(placed.mean).azimuth_rad, kAzimuth, 1e-12);
}

TEST(PlaceLight, IsAsFarFromTheSensorAsItIsSaidToBe) {
  MountEstimate mount;
  mount.mean << 0.1, -0.2, kPi / 2.0;  // the sensor looks to the base's left
  const CartesianEstimate placed = placeLight(mount, {1.5, 0.3}, kPi / 2.0, 1e-4);
  Vector5 expected;  // left of a sensor that looks to the left is behind it
  expected << 0.1 - 1.5, -0.2, mount.mean;
  EXPECT_LT((placed.mean - expected).norm(), 1e-12);
}

TEST(WidenLight, AddsAVarianceInEveryDirection) {
  CartesianEstimate estimate;
  estimate.mean << 3.0, 4.0, 0.1, 0.0, 0.0;
  estimate.covariance = Matrix5::Identity();
  const CartesianEstimate wide = widenLight(StateEstimate::of(estimate), 0.2, 0.0).cartesian();
  Matrix5 expected = Matrix5::Identity();
  expected.topLeftCorner<2, 2>().diagonal().setConstant(1.0 + 0.2 * 0.2);
  EXPECT_LT((wide.covariance - expected).norm(), 1e-12);
}

TEST(WidenLight, LeavesTheMountAlone) {
  CartesianEstimate estimate;
  estimate.mean << 3.0, 4.0, 0.1, 0.0, 0.0;
  estimate.covariance = Matrix5::Identity();
  const CartesianEstimate wide = widenLight(StateEstimate::of(estimate), 0.0, 0.1).cartesian();
  const Matrix5 change = wide.covariance - estimate.covariance;
  EXPECT_EQ(change.rightCols(3).norm(), 0.0);
  // 5 m away: 0.5 m across the line of sight (-0.8, 0.6), nothing along it
  const Eigen::Matrix2d added = change.topLeftCorner<2, 2>();
  EXPECT_NEAR(added.trace(), 0.25, 1e-12);
  EXPECT_NEAR((added * Eigen::Vector2d(0.6, 0.8)).norm(), 0.0, 1e-12);
}

// ---- association ----

Bearing candidate(double azimuth_rad, double stddev_rad) {
  return bearingOf(azimuth_rad, stddev_rad * stddev_rad);
}

constexpr double kGate = 9.0;  // three sigmas
const AzimuthPrediction kExpected{1.0, 1e-4};

TEST(Associate, TakesTheNearestAndGatesTheFar) {
  const Association found =
      associate(kExpected, {candidate(2.0, 0.01), candidate(1.01, 0.01)}, kGate);
  EXPECT_EQ(found.kind, Association::Kind::kFound);
  EXPECT_EQ(found.candidate, 1U);
  EXPECT_NEAR(found.innovation.nis(), 0.5, 1e-9);
  EXPECT_EQ(associate(kExpected, {candidate(2.0, 0.01)}, kGate).kind, Association::Kind::kGated);
  EXPECT_EQ(associate(kExpected, {}, kGate).kind, Association::Kind::kNothingSeen);
}

TEST(Associate, ChoosesNoneOfTwoThatAreAboutAsLikely) {
  const auto both = associate(kExpected, {candidate(1.01, 0.01), candidate(0.985, 0.01)}, kGate);
  EXPECT_EQ(both.kind, Association::Kind::kAmbiguous);
}

TEST(AddEarlier, AgreesWithTheInformationForm) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, kMountSize, 5> H;  // the mount stands before the light
  H << Eigen::Matrix3d::Identity(), Eigen::Matrix<double, kMountSize, 2>::Zero();
  for (int i = 0; i < 20; ++i) {
    StateEstimate estimate{{0, 1}, Vector5::Zero(), randomCovariance(&random)};
    MountEstimate earlier{Eigen::Vector3d::Zero(), randomCovariance(&random).topLeftCorner<3, 3>()};
    for (int j = 0; j < kMountSize; ++j) earlier.mean(j) = 0.3 * normal(random);
    const Matrix5 before = estimate.covariance.inverse();
    addEarlier(lastingPart(earlier), ErrorPriors(), &estimate);
    const Matrix5 information = before + H.transpose() * earlier.covariance.inverse() * H;
    const Vector5 pull = H.transpose() * earlier.covariance.inverse() * earlier.mean;
    EXPECT_LT((estimate.covariance * information - Matrix5::Identity()).norm(), 1e-9);
    EXPECT_LT((estimate.mean - information.inverse() * pull).norm(), 1e-9);
  }
}

// What was assumed of the errors beforehand stands in both and counts once.
TEST(AddEarlier, CountsThePriorsOfTheErrorsOnce) {
  ErrorPriors priors;
  priors.setBlock(WheelScales::kName, 0.1);
  const int errors = placeOf<WheelScales>() + WheelScales::kSize;
  const StateLayout layout{errors, 1};
  const int scales = kMountSize + placeOf<WheelScales>();
  const std::vector<int> shared = {0, 1, 2, scales, scales + 1};
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  // their covariances: small beside the priors, as after many measurements
  StateEstimate earlier = StateEstimate::zero(layout);
  StateEstimate estimate = StateEstimate::zero(layout);
  const Eigen::MatrixXd known = 0.02 * 0.02 * randomCovariance(&random);
  earlier.covariance(shared, shared) = known;
  Eigen::MatrixXd before = 1e-4 * Eigen::MatrixXd::Identity(layout.size(), layout.size());
  before(shared, shared) += 0.02 * 0.02 * randomCovariance(&random);
  estimate.covariance = before;
  for (const int place : shared) {
    earlier.mean(place) = 0.02 * normal(random);
    estimate.mean(place) = 0.02 * normal(random);
  }
  const StateVector mean = estimate.mean;
  addEarlier(lastingPart(earlier), priors, &estimate);

  // of what was measured earlier alone
  Eigen::MatrixXd information = known.inverse();
  Eigen::VectorXd pull = information * earlier.mean(shared);
  information.diagonal().tail<2>().array() -= 1.0 / (0.1 * 0.1);
  Eigen::MatrixXd sum = before.inverse();
  Eigen::VectorXd pulls = sum * mean;
  sum(shared, shared) += information;
  pulls(shared) += pull;
  EXPECT_LT((estimate.covariance * sum - Eigen::MatrixXd::Identity(sum.rows(), sum.cols())).norm(),
            1e-9);
  EXPECT_LT((estimate.mean - sum.inverse() * pulls).norm(), 1e-9);
}

/// Three errors and two lights; each number and each covariance is another one.
StateEstimate numberedEstimate() {
  StateEstimate estimate = StateEstimate::zero({3, 2});
  const int size = estimate.layout.size();
  for (int i = 0; i < size; ++i) {
    estimate.mean(i) = i + 1;
    for (int j = 0; j < size; ++j) estimate.covariance(i, j) = (i + 1) * (j + 1);
  }
  return estimate;
}

// The mount and the wheels' scales, the fifth and the sixth number, do; how late a camera is does
// not.
TEST(LastingPart, IsWithoutWhatIsAnotherAtTheNextStart) {
  const StateEstimate lasting = lastingPart(numberedEstimate());
  ASSERT_EQ(lasting.layout.size(), kMountSize + kErrorCount);
  StateVector number = StateVector::Zero(lasting.layout.size());
  number.head(6) << 1, 2, 3, 0, 5, 6;
  EXPECT_EQ(lasting.mean, number);
  EXPECT_EQ(lasting.covariance, StateMatrix(number * number.transpose()));
}

// Of numbers whose covariance is the product of their means, that of a part is it, too.
TEST(PartOf, TakesTheMountTheFirstErrorsAndTheLightsThatAreAskedFor) {
  const StateEstimate part = partOf(numberedEstimate(), 1, {std::nullopt, 1});
  StateVector mean(8);
  mean << 1, 2, 3, 4, 0, 0, 9, 10;  // x, y, yaw, one error, an unknown light, the second light
  EXPECT_EQ(part.mean, mean);
  StateMatrix covariance = mean * mean.transpose();
  covariance(4, 4) = covariance(5, 5) = 100.0 * 100.0;
  EXPECT_EQ(part.covariance, covariance);
}

TEST(PartOf, ErrorsThatAreNotThereAreNone) {
  const StateEstimate part = partOf(numberedEstimate(), 5, {0});
  StateVector mean(10);
  mean << 1, 2, 3, 4, 5, 6, 0, 0, 7, 8;
  EXPECT_EQ(part.mean, mean);
  EXPECT_EQ(part.covariance, StateMatrix(mean * mean.transpose()));
}

// What is known of the robot's errors and of the other light stays.
TEST(StateEstimate, ANewMountAndLightHangTogetherWithNothingElse) {
  constexpr StateLayout kLayout{2, 2};
  StateEstimate estimate = StateEstimate::zero(kLayout);
  estimate.covariance.setConstant(3.0);
  CartesianEstimate cartesian;
  cartesian.covariance.setConstant(5.0);
  estimate.setCartesian(cartesian, 1);
  const auto is_new = [&](int i) { return i < kMountSize || i >= kLayout.lightAt(1); };
  for (int i = 0; i < kLayout.size(); ++i) {
    for (int j = 0; j < kLayout.size(); ++j) {
      const double same = is_new(i) ? 5.0 : 3.0;
      EXPECT_EQ(estimate.covariance(i, j), is_new(i) == is_new(j) ? same : 0.0) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace bearing_calibration::core
