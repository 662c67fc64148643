// The levels of the noise: found against the truth over many runs, and held where a record is
// short.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <vector>

#include "bearing_calibration/calibration/record_fit.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/noise/noise_review.h"
#include "bearing_calibration/output/quality.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

constexpr NoisePriors kPriors{1.0, 1.5};

struct Record {
  std::vector<Observation> observations;
  BatchEstimate fit;
  Vector5 truth;  ///< at the last observation
};

/// A run with its noise stated so many times as large as it is, and the batch begun at the truth.
Record recordOf(const SimulatedCase& simulated, const NoiseLevels& stated,
                const BatchConfig& config) {
  const ObservationRun run = simulate(simulated);
  Record record;
  record.observations = withNoise(run.observations, stated);
  record.fit = BatchEstimator(config).estimate(record.observations,
                                               {run.truth.back(), record.observations.size() - 1});
  record.truth = run.truth.back();
  return record;
}

SimulatedCase paperCaseOf(std::uint64_t seed, double duration_s) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = duration_s;
  return simulated;
}

Record recordOf(std::uint64_t seed, double duration_s, const NoiseLevels& stated,
                double correlation = 0.0) {
  SimulatedCase simulated = paperCaseOf(seed, duration_s);
  simulated.robot.sensor.correlation = correlation;
  BatchConfig config;
  config.reject_sigmas = 0.0;  // there is nothing to reject, and no tail to be cut
  config.slip_gain = 0.0;
  return recordOf(simulated, stated, config);
}

NoiseLevels found(const Record& record, const NoisePriors& priors = kPriors) {
  return reviewNoise(record.observations, record.fit, {}, priors, unknownsWith({})).value().levels;
}

constexpr int kRuns = 20;
constexpr double kFalseAlarm = 1e-3;

void expectInBand(double nees, double degrees) {
  EXPECT_LT(nees, chiSquareQuantile(1.0 - kFalseAlarm, degrees));
  EXPECT_GT(nees, chiSquareQuantile(kFalseAlarm, degrees));
}

const NoiseLevels kStatedTooSmall{{0.5, 0.0}, {0.25, 0.0}};

void expectFoundAsWellAsTheySay(double correlation) {
  double bearing_nees = 0.0;
  double wheel_nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const NoiseLevels levels = found(recordOf(seed, 100.0, kStatedTooSmall, correlation));
    bearing_nees += std::pow(std::log(2.0 / levels.bearing.value) / levels.bearing.log_stddev, 2);
    wheel_nees += std::pow(std::log(4.0 / levels.wheel.value) / levels.wheel.log_stddev, 2);
    EXPECT_LT(levels.bearing.log_stddev, 0.1) << seed;
  }
  expectInBand(bearing_nees, kRuns);
  expectInBand(wheel_nees, kRuns);
}

TEST(NoiseLevels, AreFoundAsWellAsTheySay) { expectFoundAsWellAsTheySay(0.0); }

TEST(NoiseLevels, AreFoundBesideACorrelationOfTheBearings) { expectFoundAsWellAsTheySay(0.7); }

// Bearing noise that lasts for 3 s resembles noise of the wheels, from which the search begins; the
// next search goes on where it ended.
TEST(NoiseLevels, OfBearingsThatLastAreNotLaidToTheWheels) {
  const double correlation = std::exp(-0.1 / 3.0);  // of bearings at 10 Hz
  constexpr double kMostSigmas = 3.5;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Record record = recordOf(seed, 200.0, {}, correlation);
    NoiseReview review;
    review.likeliest = unknownsWith({{0.2, 0.0}, {20.0, 0.0}});
    for (int searches = 0; searches < 2; ++searches) {
      review = reviewNoise(record.observations, record.fit, {}, kPriors, review.likeliest).value();
    }
    const auto& [bearing, wheel, light_size] = review.levels;
    EXPECT_LT(std::abs(std::log(bearing.value)), kMostSigmas * bearing.log_stddev) << seed;
    EXPECT_LT(std::abs(std::log(wheel.value)), kMostSigmas * wheel.log_stddev) << seed;
  }
}

// Noise that changes on the way tells less of its level than as many bearings of one level.
TEST(NoiseLevels, AreNoSurerThanTheyScatterWhereNoiseChanges) {
  constexpr double kChange = 0.35;                // of the logarithm, every few seconds
  constexpr std::size_t kBearingsPerChange = 50;  // 5 s
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  std::vector<double> logs;
  double stated_variance = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    Record record = recordOf(seed, 100.0, {});
    double factor = 1.0;
    for (std::size_t i = 0; i < record.observations.size(); ++i) {
      if (i % kBearingsPerChange == 0) factor = std::exp(kChange * normal(engine));
      record.observations[i].azimuth_variance_rad2 /= factor * factor;
    }
    const NoiseLevels levels = found(record);
    logs.push_back(std::log(levels.bearing.value));
    stated_variance += std::pow(levels.bearing.log_stddev, 2) / kRuns;
  }
  const Eigen::Map<const Eigen::VectorXd> log(logs.data(), kRuns);
  expectInBand((log.array() - log.mean()).matrix().squaredNorm() / stated_variance, kRuns - 1);
}

// A record that is cut still tells of the noise: two drives tell as much as they do one by one.
TEST(NoiseLevels, AreFoundBetterWithWhatWasGivenAway) {
  double bearing_nees = 0.0, wheel_nees = 0.0;
  double bearing_precision = 0.0, bearing_precision_of_both = 0.0;
  double wheel_precision = 0.0, wheel_precision_alone = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Record given_away = recordOf(seed, 50.0, kStatedTooSmall);
    const Record record = recordOf(kRuns + seed, 50.0, kStatedTooSmall);
    const NoiseReview before =
        reviewNoise(given_away.observations, given_away.fit, {}, kPriors, unknownsWith({})).value();
    NoiseInformation told_before;
    told_before.give(1.0, before.told);
    const NoiseLevels alone = found(record);
    const NoiseLevels levels =
        reviewNoise(record.observations, record.fit, {}, kPriors, unknownsWith({}), told_before)
            .value()
            .levels;
    bearing_nees += std::pow(std::log(2.0 / levels.bearing.value) / levels.bearing.log_stddev, 2);
    wheel_nees += std::pow(std::log(4.0 / levels.wheel.value) / levels.wheel.log_stddev, 2);
    const auto precision = [](const NoiseFactor& factor) {
      return 1.0 / (factor.log_stddev * factor.log_stddev);
    };
    bearing_precision += precision(levels.bearing);
    bearing_precision_of_both += precision(alone.bearing) + precision(before.levels.bearing) -
                                 1.0 / (kPriors.bearing_stddev * kPriors.bearing_stddev);
    wheel_precision += precision(levels.wheel);
    wheel_precision_alone += precision(alone.wheel);
  }
  EXPECT_NEAR(bearing_precision / bearing_precision_of_both, 1.0, 0.2);
  EXPECT_GT(wheel_precision, 1.3 * wheel_precision_alone);
  expectInBand(bearing_nees, kRuns);
  expectInBand(wheel_nees, kRuns);
}

// Levels drawn from their prior: then the mount must be as sure as it says.
TEST(NoiseLevels, WidenTheMountByWhatIsNotKnownOfThem) {
  const NoisePriors priors{1.0, 2.0};
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  double nees = 0.0;
  for (std::uint64_t seed = 1; seed <= 2 * kRuns; ++seed) {
    const NoiseLevels stated{{std::exp(priors.bearing_stddev * normal(engine)), 0.0},
                             {std::exp(priors.wheel_stddev * normal(engine)), 0.0}};
    Record record = recordOf(seed, 50.0, stated);
    const NoiseLevels levels = found(record, priors);
    record.fit = BatchEstimator({}).estimate(withNoise(record.observations, levels),
                                             surestStart(record.fit));
    const NoiseReview review =
        reviewNoise(record.observations, record.fit, {}, priors, unknownsWith(levels)).value();
    const CartesianEstimate fit = record.fit.last.cartesian();
    const CartesianEstimate estimate =
        changedAs(record.fit.last, record.fit.last, review.average).cartesian();
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix5>(estimate.covariance - fit.covariance)
                  .eigenvalues()
                  .minCoeff(),
              -1e-12);
    const Eigen::Vector3d error = (estimate.mean - record.truth).tail<3>();
    nees += error.dot(estimate.covariance.bottomRightCorner<3, 3>().ldlt().solve(error));
  }
  expectInBand(nees, 3.0 * 2.0 * kRuns);
}

TEST(NoiseLevels, ASlipIsNotLaidToTheWheelsNoise) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedCase simulated = paperCaseOf(seed, 60.0);
    simulated.robot.faults.slips.push_back({{30.0, 0.4}, WheelSlip::Wheel::kLeft, 0.7});
    const Record record = recordOf(simulated, {}, BatchConfig());
    ASSERT_FALSE(record.fit.slips.empty()) << seed;
    const NoiseFactor wheel = found(record).wheel;
    EXPECT_LT(std::abs(std::log(wheel.value)), 3.5 * wheel.log_stddev) << seed;
  }
}

TEST(NoiseLevels, NoiseOfTheWheelsIsNotLaidToSlips) {
  int with_slips = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Record record = recordOf(paperCaseOf(seed, 60.0), {{1.0, 0.0}, {0.01, 0.0}}, {});
    with_slips += record.fit.slips.empty() ? 0 : 1;
    const NoiseFactor wheel = found(record, {1.0, 2.0}).wheel;
    EXPECT_LT(std::abs(std::log(wheel.value / 100.0)), 3.5 * wheel.log_stddev) << seed;
  }
  EXPECT_GT(with_slips, 0) << "else nothing was tried";
}

TEST(NoiseLevels, DifferencesOfNeighboursTellTheBearings) {
  for (double factor : {0.3, 1.0, 4.0}) {
    const Record record = recordOf(1, 60.0, {{1.0 / factor, 0.0}, {1.0, 0.0}});
    EXPECT_NEAR(bearingLevelFromDifferences(record.observations), factor, 0.15 * factor);
  }
  EXPECT_EQ(bearingLevelFromDifferences({}), 1.0);
}

TEST(NoiseLevels, NeighboursMayBeUnevenlySpaced) {
  constexpr double kFactor = 4.0;
  Record record = recordOf(1, 60.0, {{1.0 / kFactor, 0.0}, {1.0, 0.0}});
  std::vector<Observation>& observations = record.observations;
  const Duration interval = observations[1].stamp - observations[0].stamp;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (i % 3 != 0) observations[i].stamp += interval / 5;  // every third interval is longer
  }
  EXPECT_NEAR(bearingLevelFromDifferences(observations), kFactor, 0.15 * kFactor);
}

// With levels that are known, the review is the fit once more, elevations and all.
TEST(NoiseLevels, ThatAreKnownLeaveTheFitAlone) {
  SimulatedCase simulated = paperCaseOf(1, 60.0);
  simulated.robot.sensor.elevation_stddev_rad = radiansFromDegrees(1.0);
  simulated.robot.sensor.roll_rad = 0.02;
  simulated.lights.front().height_m = 0.4;
  BatchConfig config;
  config.errors.setBlock(SensorTilt::kName, 0.035);
  config.errors.setLightHeight(0.4, 0.1);
  const Record record = recordOf(simulated, {}, config);
  const NoiseReview review =
      reviewNoise(record.observations, record.fit, config.errors, {1e-4, 1e-4}, unknownsWith({}))
          .value();
  const CartesianEstimate fit = record.fit.last.cartesian();
  const CartesianEstimate average = review.average.cartesian();
  for (int i = 0; i < 5; ++i) {
    const double stddev = std::sqrt(fit.covariance(i, i));
    EXPECT_NEAR(std::sqrt(average.covariance(i, i)), stddev, 0.1 * stddev) << i;
    EXPECT_NEAR(average.mean(i), fit.mean(i), 0.2 * stddev) << i;
  }
}

// What is given away of a record is averaged like the rest of it.
TEST(NoiseLevels, AreAveragedOverWhereARecordIsCut) {
  const Record record = recordOf(1, 60.0, {});
  const auto averageWith = [&](const NoiseReview& review, std::size_t cut) {
    return averageAfter(cut, record.observations, record.fit, {}, review);
  };
  const auto reviewWith = [&](const NoisePriors& priors) {
    return reviewNoise(record.observations, record.fit, {}, priors, unknownsWith({})).value();
  };
  const std::size_t all = record.observations.size();
  const NoiseReview unknown = reviewWith(kPriors);
  EXPECT_EQ(averageWith(unknown, all).mean, unknown.average.mean);
  EXPECT_EQ(averageWith(unknown, all).covariance, unknown.average.covariance);
  const std::size_t half = all / 2;
  const StateEstimate fit =
      BatchEstimator({}).filteredAt(half - 1, record.observations, record.fit);
  const StateEstimate average = averageWith(reviewWith({1e-4, 1e-4}), half);
  for (int i = 0; i < fit.layout.size(); ++i) {
    const double stddev = std::sqrt(fit.covariance(i, i));
    EXPECT_NEAR(std::sqrt(average.covariance(i, i)), stddev, 0.1 * stddev) << i;
    EXPECT_NEAR(average.mean(i), fit.mean(i), 0.2 * stddev) << i;
  }
}

// The mount of a part that is given away is the average's own, and at least as uncertain. A fit
// with other slips than those of the part's own fit would move it twice.
TEST(NoiseLevels, MoveWhatIsGivenAwayToItsOwnAverage) {
  const Record record = recordOf(1, 60.0, {{2.0, 0.0}, {0.25, 0.0}});
  const NoiseReview review =
      reviewNoise(record.observations, record.fit, {}, kPriors, unknownsWith({})).value();
  const std::size_t half = record.observations.size() / 2;
  const StateEstimate fit =
      BatchEstimator({}).filteredAt(half - 1, record.observations, record.fit);
  const StateEstimate average = averageAfter(half, record.observations, record.fit, {}, review);
  const RecordPart part =
      RecordFit(InitializerConfig()).oldestPart(record.observations, record.fit, half, average);
  ASSERT_EQ(part.count, half);
  const double stddev_m = std::sqrt(fit.covariance(0, 0));
  EXPECT_GT(std::abs(average.mean(0) - fit.mean(0)), 0.05 * stddev_m) << "nothing to move";
  EXPECT_TRUE(part.known.mean.isApprox(average.mean, 1e-9)) << part.known.mean.transpose();
  for (const StateEstimate& least : {fit, average}) {
    const StateMatrix beyond = part.known.covariance - least.covariance;
    EXPECT_GT(eigenOf(beyond).values.minCoeff(), -1e-9);
  }
}

TEST(NoiseLevels, SurpriseWhereTheyAreFarAboveWhatWasStated) {
  const NoisePriors priors{1.0, 2.0};
  EXPECT_FALSE(priors.isSurprisedBy({{4.0, 0.0}, {18.0, 0.0}}));
  EXPECT_TRUE(priors.isSurprisedBy({{5.0, 0.0}, {1.0, 0.0}}));
  EXPECT_TRUE(priors.isSurprisedBy({{1.0, 0.0}, {25.0, 0.0}}));
  EXPECT_FALSE(NoisePriors{}.isSurprisedBy({{100.0, 0.0}, {100.0, 0.0}}));
  EXPECT_FALSE((NoisePriors{0.0, 2.0}).isSurprisedBy({{100.0, 0.0}, {1.0, 0.0}}));
  EXPECT_FALSE((NoisePriors{1.0, 0.0}).isSurprisedBy({{1.0, 0.0}, {100.0, 0.0}}));
}

/// Bearings of a light of which another point is seen each time, so far beside its place.
Record recordOfWideLight(std::uint64_t seed, double size_m) {
  SimulatedCase simulated = paperCaseOf(seed, 100.0);
  const ObservationRun run = simulate(simulated);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Record record{run.observations, {}, run.truth.back()};
  for (std::size_t i = 0; i < record.observations.size(); ++i) {
    const Vector5& truth = run.truth[i];
    const double range_m = (truth.head<2>() - truth.segment<2>(CartesianIndex::kSensorX)).norm();
    record.observations[i].azimuth_rad += size_m / range_m * normal(engine);
  }
  BatchConfig config;
  config.reject_sigmas = 0.0;
  config.slip_gain = 0.0;
  record.fit = BatchEstimator(config).estimate(record.observations,
                                               {record.truth, record.observations.size() - 1});
  return record;
}

TEST(NoiseLevels, ALightThatIsNoPointIsNoisierNearby) {
  constexpr double kSize_m = 0.025;  // 1 deg at 1.4 m
  double size_nees = 0.0;
  double bearing_nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const auto [bearing, wheel, size] = found(recordOfWideLight(seed, kSize_m));
    size_nees += std::pow(std::log(size.stddev_m / kSize_m) / size.log_stddev, 2);
    bearing_nees += std::pow(std::log(bearing.value) / bearing.log_stddev, 2);
  }
  expectInBand(size_nees, kRuns);
  expectInBand(bearing_nees, kRuns);
}

TEST(NoiseLevels, ALightThatIsAPointIsFoundToBeSmall) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const LightSize size = found(recordOfWideLight(seed, 0.0)).light_size;
    constexpr double kNoise_m = 0.035;  // 1 deg at 2 m
    EXPECT_LT(size.stddev_m * std::exp(2.0 * size.log_stddev), kNoise_m) << seed;
  }
}

TEST(NoiseLevels, ALightIsAPointWhereTheBearingsNoiseIsKnown) {
  const NoiseLevels levels = found(recordOfWideLight(1, 0.1), {0.0, 1.5});
  EXPECT_LT(levels.light_size.stddev_m, 1e-12);
  EXPECT_EQ(levels.light_size.log_stddev, 0.0);
}

TEST(NoiseLevels, ALightsSizeWidensNearBearingsMost) {
  Bearing bearing;
  bearing.azimuth_variance_rad2 = 4e-4;
  const NoiseLevels noise{{0.5, 0.0}, {}, {0.02, 0.0}};
  EXPECT_NEAR(withNoise(bearing, noise, 1.0).azimuth_variance_rad2, 1e-4 + 4e-4, 1e-12);
  EXPECT_NEAR(withNoise(bearing, noise, 4.0).azimuth_variance_rad2, 1e-4 + 2.5e-5, 1e-12);
  Observation observation;
  observation.azimuth_variance_rad2 = 4e-4;
  const Observation noisy = withNoise(std::vector{observation}, noise).front();
  EXPECT_NEAR(azimuthVarianceAt(noisy, 4.0), 1e-4 + 2.5e-5, 1e-12);
  EXPECT_NEAR(noise.atMost().light_size.stddev_m, 0.02, 1e-12);
}

TEST(NoiseLevels, AFactorThatIsNotLookedForStaysAsStated) {
  const Record record = recordOf(1, 50.0, {});
  const NoiseLevels levels = found(record, {1.0, 0.0});
  EXPECT_EQ(levels.wheel.value, 1.0);
  EXPECT_EQ(levels.wheel.log_stddev, 0.0);
  EXPECT_LT(std::abs(std::log(levels.bearing.value)), 3.0 * levels.bearing.log_stddev);
}

TEST(NoiseLevels, TheWheelsOfAShortWayAreHeldAtTheirPrior) {
  const Record record = recordOf(2, 5.0, {});
  const std::vector<BlockReport> reports = reportNoise({0.7, 0.7}, found(record, {0.7, 0.7}), {});
  EXPECT_EQ(reports[0].status, BlockStatus::kEstimated);
  EXPECT_EQ(reports[1].status, BlockStatus::kHeldAtPrior);
  EXPECT_FALSE(reports[1].note.empty());
  EXPECT_EQ(reports[3].status, BlockStatus::kOff);
}

// A mirror's law leaves 3 % of the harmonic out (mirror_misalignment_test), which lasts and which
// no scatter shows: bearings that state it, and scatter less, keep it.
TEST(NoiseLevels, OfBearingsAreNotBelowWhatTheMirrorsLawLeavesOut) {
  constexpr double kStated_rad = 0.01;
  constexpr double kLeftOut = 0.8;  // of what is stated
  constexpr double kScatter = 0.25;
  SimulatedCase simulated = paperCaseOf(1, 50.0);
  simulated.robot.sensor.stddev_rad = kScatter * kStated_rad;
  BatchConfig config;
  config.errors.setGeometry({kLeftOut * kStated_rad / 0.03, 0.0, 0.0});
  const Record record = recordOf(simulated, {{1.0 / kScatter, 0.0}, {1.0, 0.0}}, config);
  const NoiseLevels levels =
      reviewNoise(record.observations, record.fit, config.errors, kPriors, unknownsWith({}))
          .value()
          .levels;
  EXPECT_NEAR(levels.bearing.value, kLeftOut, 1e-6);
}

TEST(NoiseLevels, CorrelationForgetsItselfInItsTime) {
  std::vector<Observation> observations(400);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    observations[i].stamp = Stamp(std::chrono::milliseconds(100 * i));
  }
  const CorrelationTime time = correlationTime(observations, std::exp(-0.5));
  EXPECT_NEAR(time.value_s, 0.2, 1e-9);  // two intervals
  EXPECT_NEAR(time.stddev_s, 0.1 / (std::exp(-0.5) * 0.25) / 20.0, 1e-9);
  EXPECT_EQ(correlationTime(observations, 0.0).value_s, 0.0);
}

TEST(NoiseLevels, PriorsAreChecked) {
  EXPECT_TRUE(errorsOf(kPriors).empty());
  EXPECT_EQ((errorsOf(NoisePriors{-1.0, NAN}).size()), 2U);
}

}  // namespace
}  // namespace bearing_calibration::core
