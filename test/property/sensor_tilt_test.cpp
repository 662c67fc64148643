// A tilted sensor: its geometry against rotations in space, the filter's and the batch's use of
// elevations, and what is said of a tilt that they do not tell.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <utility>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "support/mount_chi_square.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using testing::mountChiSquare;

/// The same at every run.
class Draws {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

 private:
  std::mt19937_64 engine_{20060515};
};

/// A light in the frame of a sensor that stands somewhere in space.
Eigen::Vector3d inTiltedSensor(const Vector5& state, const ErrorVector& errors) {
  const auto tilt = errors.segment<3>(placeOf<SensorTilt>());
  const auto base_from_sensor =
      Eigen::Translation3d(state(CartesianIndex::kSensorX), state(CartesianIndex::kSensorY), 0.0) *
      Eigen::AngleAxisd(state(CartesianIndex::kSensorYaw), Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(tilt(1), Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(tilt(0), Eigen::Vector3d::UnitX());
  return base_from_sensor.inverse() *
         Eigen::Vector3d(state(CartesianIndex::kLightX), state(CartesianIndex::kLightY), tilt(2));
}

ErrorVector tiltOf(double roll_rad, double pitch_rad, double light_height_m) {
  ErrorVector errors = ErrorVector::Zero();
  errors.segment<3>(placeOf<SensorTilt>()) << roll_rad, pitch_rad, light_height_m;
  return errors;
}

TEST(SensorTilt, ATiltedSensorSeesWhatGeometryInSpaceSays) {
  Draws draws;
  for (int i = 0; i < 50; ++i) {
    Vector5 state;
    state << draws.between(0.5, 3.0), draws.between(-3.0, 3.0), draws.between(-0.2, 0.2),
        draws.between(-0.2, 0.2), draws.between(-kPi, kPi);
    const ErrorVector errors =
        tiltOf(draws.between(-0.3, 0.3), draws.between(-0.3, 0.3), draws.between(-0.5, 0.5));
    const Eigen::Vector3d light = inTiltedSensor(state, errors);
    constexpr double kRounding = 1e-12;
    Observation seen;
    seen.azimuth_rad = std::atan2(light.y(), light.x());
    seen.elevation = {std::asin(light.normalized().z()), 1.0};
    EXPECT_NEAR(residualOf(seen, state, errors), 0.0, kRounding);
    EXPECT_NEAR(*elevationResidualOf(seen, state, errors), 0.0, kRounding);
  }
}

// model.md, eq. 21: to first order in the tilt.
TEST(SensorTilt, ByItsAzimuthsATiltIsAShiftedMount) {
  constexpr double kHeight_m = 0.4;
  constexpr double kTilt_rad = 1e-5;
  constexpr double kSecondOrder = 10.0 * kTilt_rad * kTilt_rad;
  const Vector5 state = (Vector5() << 1.0, 0.5, 0.1, -0.05, 0.3).finished();
  const Eigen::Vector2d shift =
      rotation2(0.3) * Eigen::Vector2d(-2.0 * kTilt_rad, -kTilt_rad) * kHeight_m;
  Vector5 shifted = state;
  shifted.segment<2>(CartesianIndex::kSensorX) += shift;
  Observation seen;
  seen.azimuth_rad = azimuthFromCartesian(shifted).azimuth_rad;
  const ErrorVector tilt = tiltOf(kTilt_rad, -2.0 * kTilt_rad, kHeight_m);
  EXPECT_NEAR(residualOf(seen, state, tilt), 0.0, kSecondOrder);
  EXPECT_GT(std::abs(residualOf(seen, state, ErrorVector::Zero())), 1000.0 * kSecondOrder);
}

// An elevation that is far off pulls by its limit, however far off it is.
TEST(SensorTilt, AWildElevationPullsNoMoreThanAnUnlikelyOne) {
  constexpr double kStddev_rad = 0.01;
  CartesianEstimate start;
  start.mean << 1.0, 0.5, 0.1, -0.05, 0.3;
  start.covariance = 1e-6 * Matrix5::Identity();
  ErrorPriors priors;
  priors.setBlock(SensorTilt::kName, 0.02);
  const auto heightAfter = [&](const std::optional<Elevation>& elevation) {
    LiveFilter filter(StateEstimate::of(start, errorsInUse(priors), priorEstimate(priors)));
    Bearing bearing;
    bearing.azimuth_rad = azimuthFromCartesian(start.mean).azimuth_rad;
    bearing.azimuth_variance_rad2 = 1e-4;
    if (elevation) {
      bearing.elevation_rad = elevation->angle_rad;
      bearing.elevation_variance_rad2 = elevation->variance_rad2;
    }
    filter.update(bearing);
    return filter.estimate().errors().mean(heightAt(0));
  };
  EXPECT_EQ(heightAfter(std::nullopt), 0.0);
  const double ordinary = heightAfter(Elevation{0.05, kStddev_rad * kStddev_rad});
  const double range_m = start.range();
  EXPECT_NEAR(ordinary, 0.05 * range_m, 0.2 * 0.05 * range_m);
  const double wild = heightAfter(Elevation{1.0, kStddev_rad * kStddev_rad});
  EXPECT_NEAR(heightAfter(Elevation{1.5, kStddev_rad * kStddev_rad}), wild, 1e-12);
  EXPECT_LT(wild, 0.7);
}

// A light of known height and a tilt that nobody measures: 0.4 m times 0.02 rad.
TEST(SensorTilt, TheReportSaysWhatATiltThatIsNotLookedForLeavesOpen) {
  ErrorPriors priors;
  priors.setLightHeight(-0.4, 0.1);
  EXPECT_EQ(errorsInUse(priors), 0);
  const std::string note = reportBlocks(priors, priorEstimate(priors), 0.02).back().note;
  EXPECT_EQ(note.rfind("rho is uncertain by 8.0 mm", 0), 0U) << note;
  EXPECT_TRUE(reportBlocks(priors, priorEstimate(priors), 0.0).back().note.empty());
}

TEST(SensorTilt, ATiltNeedsALightOfUncertainHeight) {
  ErrorPriors priors;
  priors.setBlock("sensor_tilt", 0.035);
  EXPECT_TRUE(errorsOf(priors).empty());
  priors.setLightHeight(0.1, 0.0);
  const std::vector<std::string> errors = errorsOf(priors);
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_NE(errors[0].find("errors/light_height_stddev"), std::string::npos);
}

/// Gives these numbers where they are asked for.
class GivenNumbers : public Parameters {
 public:
  explicit GivenNumbers(std::map<std::string, double> numbers) : numbers_(std::move(numbers)) {}

 private:
  bool readInto(const std::string& name, const Target& target) override {
    const auto number = numbers_.find(name);
    if (number == numbers_.end()) return false;
    *std::get<double*>(target) = number->second;
    return true;
  }

  std::map<std::string, double> numbers_;
};

TEST(SensorTilt, TheLightsHeightIsKnownAsItWasSaid) {
  GivenNumbers given({{"errors/sensor_tilt_stddev", 0.035},
                      {"errors/light_height", -1.2},
                      {"errors/light_height_stddev", 0.3}});
  ErrorPriors priors;
  priors.declare(given);
  EXPECT_TRUE(given.errors().empty());
  EXPECT_EQ(priors.light_height_m, -1.2);
  EXPECT_EQ(priors.light_height_stddev_m, 0.3);
  const ErrorEstimate known = priorEstimate(priors);
  EXPECT_EQ(known.mean(heightAt(0)), -1.2);
  EXPECT_NEAR(known.covariance(heightAt(0), heightAt(0)), 0.3 * 0.3, 1e-12);
}

TEST(SensorTilt, ABearingHasAnElevationWhereItsVarianceIsPositive) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Bearing bearing;
  EXPECT_FALSE(elevationOf(bearing));
  bearing.elevation_rad = 0.1;
  for (double variance : {kNan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    bearing.elevation_variance_rad2 = variance;
    EXPECT_FALSE(elevationOf(bearing)) << variance;
  }
  bearing.elevation_variance_rad2 = 0.01;
  ASSERT_TRUE(elevationOf(bearing));
  EXPECT_EQ(elevationOf(bearing)->angle_rad, 0.1);
}

/// Everything at once, the separation known, on the drive that a person should drive.
SimulatedCase tiltedCase(std::uint64_t seed) {
  SimulatedCase simulated = cornerCase(seed);
  ImperfectRobot how;
  how.time_offset_s = 0.05;
  how.ratio = 0.01;
  how.scale = 0.01;
  how.tilt_rad = radiansFromDegrees(2.0);
  how.harmonic_rad = radiansFromDegrees(2.5);
  makeImperfect(simulated, how, seed);
  simulated.robot.sensor.elevation_stddev_rad = radiansFromDegrees(1.0);
  simulated.lights.front().height_m = 0.4;
  simulated.looked_for = usualErrors();
  simulated.looked_for.setBlock(WheelSeparation::kName, 0.0);
  simulated.looked_for.setBlock(MirrorHarmonic::kName, 0.03);
  simulated.looked_for.setBlock(SensorTilt::kName, 0.035);
  return simulated;
}

BatchEstimate batchOf(const SimulatedCase& simulated, const ObservationRun& run) {
  BatchConfig config;
  config.errors = simulated.looked_for;
  return BatchEstimator(config).estimate(run.observations,
                                         {run.truth.back(), run.observations.size() - 1});
}

// The bar of imperfect.md, by as many runs as fit into a test.
TEST(SensorTilt, ElevationsTellATiltFromAShiftedMount) {
  constexpr int kRuns = 16;
  double nees = 0.0;
  double phi_squares = 0.0;
  double rho_squares = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedCase simulated = tiltedCase(seed);
    const ObservationRun run = simulate(simulated);
    const BatchEstimate batch = batchOf(simulated, run);
    ASSERT_TRUE(batch.converged) << "seed " << seed;
    nees += mountChiSquare(batch.last.cartesian(), run.truth.back());
    const Eigen::Vector2d found = batch.last.mount().mean.head<2>();
    const Eigen::Vector2d truth = simulated.robot.base_from_sensor.position_m;
    phi_squares +=
        std::pow(wrapAngle(std::atan2(found.y(), found.x()) - std::atan2(truth.y(), truth.x())), 2);
    rho_squares += std::pow(found.norm() - truth.norm(), 2);
    for (const BlockReport& report : reportBlocks(simulated.looked_for, batch.last.errors())) {
      if (report.name != SensorTilt::kName) continue;
      EXPECT_EQ(report.status, BlockStatus::kEstimated);
      EXPECT_TRUE(report.note.empty()) << report.note;
    }
  }
  EXPECT_LT(degreesFromRadians(std::sqrt(phi_squares / kRuns)), 0.8);
  EXPECT_LT(std::sqrt(rho_squares / kRuns), 0.002);
  EXPECT_LT(nees, chiSquareQuantile(0.999, 3.0 * kRuns));
  EXPECT_GT(nees, chiSquareQuantile(0.001, 3.0 * kRuns));
}

// Without elevations a tilt of 2 deg under a light 0.4 m high is a mount 14 mm off, to a model that
// knows no tilt; one that does says that it cannot tell, and by how much.
TEST(SensorTilt, WithoutElevationsTheTiltIsHeldAndItsDoubtIsSaid) {
  SimulatedCase simulated = tiltedCase(1);
  simulated.robot.sensor.elevation_stddev_rad = 0.0;
  simulated.looked_for.setLightHeight(0.4, 0.05);
  const ObservationRun run = simulate(simulated);
  const BatchEstimate batch = batchOf(simulated, run);
  ASSERT_TRUE(batch.converged);
  const BlockReport report = reportBlocks(simulated.looked_for, batch.last.errors()).back();
  EXPECT_EQ(report.status, BlockStatus::kHeldAtPrior);
  EXPECT_NE(report.note.find("rho is uncertain by 14."), std::string::npos) << report.note;
  EXPECT_LT(mountChiSquare(batch.last.cartesian(), run.truth.back()),
            chiSquareQuantile(0.999, 3.0));
  simulated.looked_for.setBlock(SensorTilt::kName, 0.0);
  const BatchEstimate unaware = batchOf(simulated, run);
  constexpr double kWrong = 25.0;
  EXPECT_GT(mountChiSquare(unaware.last.cartesian(), run.truth.back()), kWrong);
}

// Elevations that are nothing but noise in every tenth observation do no harm.
TEST(SensorTilt, WildElevationsDoNoHarm) {
  const SimulatedCase simulated = tiltedCase(2);
  ObservationRun run = simulate(simulated);
  Draws draws;
  for (std::size_t i = 0; i < run.observations.size(); i += 10) {
    run.observations[i].elevation->angle_rad = draws.between(-1.5, 1.5);
  }
  const BatchEstimate batch = batchOf(simulated, run);
  ASSERT_TRUE(batch.converged);
  EXPECT_LT(mountChiSquare(batch.last.cartesian(), run.truth.back()),
            chiSquareQuantile(0.999, 3.0));
}

}  // namespace
}  // namespace bearing_calibration::core
