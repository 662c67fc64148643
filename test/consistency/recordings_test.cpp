// The calibrator on real recordings, from nothing: each landmark alone is one calibration. Found
// through BEARING_CALIBRATION_DATA, skipped by name without it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <vector>

#include "bearing_calibration/common/chi_square.h"
#include "support/recording_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using namespace testing;  // NOLINT: this package's own test support

constexpr double kDegree = kPi / 180.0;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

/// A run of one landmark, looked at every metre from the first observation on.
struct Drive {
  struct Moment {
    double path_m;  ///< since the first observation
    CalibrationResult result;
  };
  std::vector<Moment> moments;
  CalibrationResult last;

  const CalibrationResult& after(double path_m) const {
    for (const Moment& moment : moments) {
      if (moment.path_m >= path_m) return moment.result;
    }
    return last;
  }
};

Drive drive(const LandmarkRecording& recording, const CalibratorConfig& config) {
  Calibrator calibrator(config);
  Drive story;
  auto next = recording.bearings.begin();
  double first_observation_m = -1.0;
  double next_look_m = 0.0;
  for (const WheelCounts& ticks : recording.ticks) {
    const bool seen = next != recording.bearings.begin();
    for (; next != recording.bearings.end() && next->stamp <= ticks.stamp; ++next) {
      calibrator.addBearings(*next, next->stamp);
    }
    calibrator.addTicks(ticks, ticks.stamp);
    if (!seen) continue;
    const CalibrationResult now = calibrator.result();
    if (first_observation_m < 0.0) first_observation_m = now.distance_travelled_m;
    const double path_m = now.distance_travelled_m - first_observation_m;
    if (path_m < next_look_m) continue;
    story.moments.push_back({path_m, now});
    next_look_m += 1.0;
  }
  story.last = calibrator.result();
  return story;
}

class Recordings : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!recordingsFolder()) {
      GTEST_SKIP() << "BEARING_CALIBRATION_DATA is not set: it names the folder of recordings";
    }
  }
};

// The README of the recording: per second about 7 mm along the way and 0.013 rad of heading. By
// model.md, eq. 3, at a mean speed v: heading 2 K v / b^2, along the way (K / 2 + K_c) v.
RecordingSetup litwSetup() {
  constexpr double kMeanSpeed_mps = 341.0 / 1261.0;
  constexpr double kHeading_rad = 0.013;
  constexpr double kAlong_m = 0.007;
  RecordingSetup setup;
  setup.set = "litw";
  setup.odometry = "odometry_calibrated.csv";
  setup.wheel_separation_m = 0.40;
  setup.wheel_noise.independent_k_m = kHeading_rad * kHeading_rad * setup.wheel_separation_m *
                                      setup.wheel_separation_m / (2.0 * kMeanSpeed_mps);
  setup.wheel_noise.common_k_m =
      kAlong_m * kAlong_m / kMeanSpeed_mps - 0.5 * setup.wheel_noise.independent_k_m;
  setup.latency_s = 0.11;
  setup.bearing_stddev_rad = 0.019;
  return setup;
}

constexpr std::size_t kAnyObservations = 1;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const MountError kNoEstimate{kInfinity, kInfinity, kInfinity};

class Litw : public Recordings {};

TEST_F(Litw, EachLandmarkAloneFindsTheMountFromNothing) {
  const RecordingSetup setup = litwSetup();
  const RecordedTruth truth = readTruth(setup.set);
  std::vector<double> position_m, yaw_rad, position_40_m, yaw_40_rad;
  double chi_square_sum = 0.0;
  int chi_squares = 0;
  double worst_converged = 0.0;
  std::printf("landmark  at 40 m: cm deg chi2   end: cm deg chi2  sigma cm deg  state\n");
  for (std::int32_t landmark : landmarksOf(setup, kAnyObservations)) {
    const Drive landmark_run = drive(readLandmark(setup, landmark), configFor(setup));
    ASSERT_TRUE(landmark_run.last.base_from_sensor.has_value()) << landmark_run.last.advice;
    const std::optional<MountEstimate>& at_40_m = landmark_run.after(40.0).base_from_sensor;
    const MountError at_40 = at_40_m ? errorOf(*at_40_m, truth) : kNoEstimate;
    const MountError end = errorOf(*landmark_run.last.base_from_sensor, truth);
    const Eigen::Vector3d sigma =
        landmark_run.last.base_from_sensor->covariance.diagonal().cwiseSqrt();
    std::printf("%8d  %8.2f %5.2f %5.1f  %8.2f %5.2f %5.1f  %5.2f %5.2f  %s\n", landmark,
                100.0 * at_40.position_m, at_40.yaw_rad / kDegree, at_40.chi_square,
                100.0 * end.position_m, end.yaw_rad / kDegree, end.chi_square,
                100.0 * sigma.head<2>().maxCoeff(), sigma.z() / kDegree,
                nameOf(landmark_run.last.state));
    EXPECT_LE(end.position_m, 0.05) << "landmark " << landmark;
    EXPECT_LE(end.yaw_rad, 2.0 * kDegree) << "landmark " << landmark;
    position_m.push_back(end.position_m);
    yaw_rad.push_back(end.yaw_rad);
    position_40_m.push_back(at_40.position_m);
    yaw_40_rad.push_back(at_40.yaw_rad);
    for (const Drive::Moment& moment : landmark_run.moments) {
      if (!moment.result.base_from_sensor || moment.path_m < 40.0) continue;
      const double chi_square = errorOf(*moment.result.base_from_sensor, truth).chi_square;
      chi_square_sum += chi_square;
      ++chi_squares;
      if (moment.result.state == CalibrationState::kConverged) {
        worst_converged = std::max(worst_converged, chi_square);
      }
    }
  }
  ASSERT_EQ(position_m.size(), 9U);
  std::printf(
      "median: %.2f cm %.2f deg at 40 m, %.2f cm %.2f deg at the end; mean chi-square from "
      "40 m on %.2f; worst of a CONVERGED %.2f\n",
      100.0 * median(position_40_m), median(yaw_40_rad) / kDegree, 100.0 * median(position_m),
      median(yaw_rad) / kDegree, chi_square_sum / chi_squares, worst_converged);
  EXPECT_LE(median(position_m), 0.02);
  EXPECT_LE(median(yaw_rad), 0.6 * kDegree);
  EXPECT_LE(median(position_40_m), 0.05);
  EXPECT_LE(median(yaw_40_rad), 1.5 * kDegree);
  EXPECT_LE(chi_square_sum / chi_squares, 6.0);
  EXPECT_LE(worst_converged, 16.3);
}

// Turning the sensor about its own axis turns the answer's yaw and nothing else.
TEST_F(Litw, TurningTheSensorTurnsTheYawAlone) {
  const RecordingSetup setup = litwSetup();
  const std::int32_t landmark = landmarksOf(setup, kAnyObservations).front();
  const LandmarkRecording recording = readLandmark(setup, landmark);
  const MountEstimate reference = *drive(recording, configFor(setup)).last.base_from_sensor;
  for (int turn_deg : {70, 160, 250, 340}) {
    LandmarkRecording turned = recording;
    for (BearingSet& bearings : turned.bearings) {
      double& azimuth_rad = bearings.candidates[0].azimuth_rad;
      azimuth_rad = wrapAngle(azimuth_rad + turn_deg * kDegree);
    }
    const MountEstimate estimate = *drive(turned, configFor(setup)).last.base_from_sensor;
    EXPECT_LT((estimate.mean - reference.mean).head<2>().norm(), 0.001) << turn_deg << " deg";
    EXPECT_NEAR(wrapAngle(estimate.mean.z() + turn_deg * kDegree - reference.mean.z()), 0.0,
                0.05 * kDegree)
        << turn_deg << " deg";
  }
}

struct LateResult {
  std::vector<double> offsets_s;
  std::vector<MountError> errors;
  double worst_converged = 0.0;  ///< chi-square at any moment that was called CONVERGED

  int offsetsWithin(double least_s, double most_s) const {
    return static_cast<int>(std::count_if(offsets_s.begin(), offsets_s.end(), [&](double offset_s) {
      return offset_s >= least_s && offset_s <= most_s;
    }));
  }
  double medianPosition() const {
    std::vector<double> position_m;
    for (const MountError& error : errors) position_m.push_back(error.position_m);
    return median(position_m);
  }
  double meanChiSquare() const {
    double sum = 0.0;
    for (const MountError& error : errors) sum += error.chi_square;
    return sum / static_cast<double>(errors.size());
  }
};

/// Every landmark of litw with the latency not given.
LateResult driveLate(RecordingSetup setup) {
  setup.latency_s = 0.0;
  setup.errors.setBlock("time_offset", 0.1);
  setup.errors.setBlock("wheel_scales", 0.03);
  setup.errors.setBlock("wheel_separation", 0.01);
  const RecordedTruth truth = readTruth(setup.set);
  LateResult late;
  for (std::int32_t landmark : landmarksOf(setup, kAnyObservations)) {
    const Drive run = drive(readLandmark(setup, landmark), configFor(setup));
    if (!run.last.base_from_sensor) {
      std::printf("%8d  no estimate: %s\n", landmark, run.last.advice.c_str());
      late.errors.push_back(kNoEstimate);
      continue;
    }
    const MountError end = errorOf(*run.last.base_from_sensor, truth);
    const ErrorVector& errors = run.last.robot_errors.mean;
    const double offset_s = errors(placeOf<TimeOffset>());
    std::printf(
        "%8d  %5.2f cm %5.2f deg chi2 %5.1f  offset %6.3f +- %.3f s, scales %6.3f %6.3f, "
        "noise %.2f %.1f, light %.1f cm wide  %s\n",
        landmark, 100.0 * end.position_m, end.yaw_rad / kDegree, end.chi_square, offset_s,
        std::sqrt(run.last.robot_errors.covariance(0, 0)), errors(1), errors(2),
        run.last.noise.bearing.value, run.last.noise.wheel.value,
        100.0 * run.last.noise.light_size.stddev_m, nameOf(run.last.state));
    late.errors.push_back(end);
    late.offsets_s.push_back(offset_s);
    for (const Drive::Moment& moment : run.moments) {
      if (moment.result.state != CalibrationState::kConverged) continue;
      late.worst_converged = std::max(late.worst_converged,
                                      errorOf(*moment.result.base_from_sensor, truth).chi_square);
    }
  }
  std::printf("median %.2f cm, mean chi-square %.2f, worst of a CONVERGED %.2f\n",
              100.0 * late.medianPosition(), late.meanChiSquare(), late.worst_converged);
  return late;
}

TEST_F(Litw, FindsTheLatencyByItself) {
  const LateResult late = driveLate(litwSetup());
  EXPECT_LE(late.worst_converged, 16.3);
  EXPECT_GE(late.offsetsWithin(0.08, 0.14), 7);
  EXPECT_LE(late.medianPosition(), 0.02);
}

// A stranger's robot: its owner knows the separation, and the noise is what the parameters have.
TEST_F(Litw, FindsTheMountWithNothingStatedButTheSeparation) {
  RecordingSetup setup = litwSetup();
  setup.wheel_noise = {1e-6, 0.0};
  setup.bearing_stddev_rad = 1.0 * kDegree;
  setup.noise = usualNoise();
  const LateResult late = driveLate(setup);
  for (const MountError& error : late.errors) {
    EXPECT_LE(error.position_m, 0.04);
    EXPECT_LE(error.yaw_rad, 1.5 * kDegree);
  }
  EXPECT_GE(late.offsetsWithin(0.08, 0.14), 8);
}

// Its authors' scales are 5 to 6 % off and its speed has an offset while standing, which no scale
// can put right.
TEST_F(Litw, FindsTheLatencyFromThePublishedOdometry) {
  RecordingSetup setup = litwSetup();
  setup.odometry = "odometry_published.csv";
  const LateResult late = driveLate(setup);
  EXPECT_LE(late.worst_converged, 16.3);
  EXPECT_GE(late.offsetsWithin(0.08, 0.14), 7);
}

// ---- commanded velocities are no encoders, and a mount near the centre has no phi ----

RecordingSetup mrclamSetup(const std::string& set, const std::string& odometry) {
  RecordingSetup setup;
  setup.set = set;
  setup.odometry = odometry;
  setup.wheel_separation_m = 0.258;
  setup.wheel_noise = {1e-5, 1e-4};
  setup.latency_s = 0.038;
  setup.bearing_stddev_rad = 0.008;  // residuals scatter by 0.005 to 0.008 rad
  return setup;
}

class Mrclam : public Recordings, public ::testing::WithParamInterface<const char*> {};

TEST_P(Mrclam, IsNeverConvergedFromCommandedVelocities) {
  const RecordingSetup setup = mrclamSetup(GetParam(), "odometry_commands.csv");
  for (std::int32_t landmark : landmarksOf(setup, kAnyObservations)) {
    const Drive landmark_run = drive(readLandmark(setup, landmark), configFor(setup));
    for (const Drive::Moment& moment : landmark_run.moments) {
      EXPECT_NE(moment.result.state, CalibrationState::kConverged) << "landmark " << landmark;
    }
  }
}

TEST_P(Mrclam, IsRightInXWithTheMotionOfVicon) {
  constexpr std::size_t kEnoughObservations = 250;
  const RecordingSetup setup = mrclamSetup(GetParam(), "odometry_vicon.csv");
  const RecordedTruth truth = readTruth(setup.set);
  const bool near_zero_rho = truth.base_from_sensor.position_m.norm() < 0.05;
  for (std::int32_t landmark : landmarksOf(setup, kAnyObservations)) {
    const LandmarkRecording recording = readLandmark(setup, landmark);
    const Drive landmark_run = drive(recording, configFor(setup));
    const CalibrationResult& last = landmark_run.last;
    if (!last.base_from_sensor) {
      EXPECT_LT(recording.bearings.size(), kEnoughObservations)
          << "landmark " << landmark << ": " << last.advice;
      continue;
    }
    const MountError error = errorOf(*last.base_from_sensor, truth);
    std::printf(
        "%s landmark %2d: %4zu observations, x off by %5.1f +- %.1f cm, %5.2f cm, chi2 %.1f, %s, "
        "%s\n",
        GetParam(), landmark, recording.bearings.size(),
        100.0 * (last.base_from_sensor->mean.x() - truth.base_from_sensor.position_m.x()),
        100.0 * std::sqrt(last.base_from_sensor->covariance(0, 0)), 100.0 * error.position_m,
        error.chi_square, nameOf(last.state),
        last.paper_state->phi_psi_determined ? "phi determined" : "phi undetermined");
    if (recording.bearings.size() >= kEnoughObservations) {
      // 5 cm; a record that cannot tell x so well is held to 99 % of what it says of itself
      constexpr double kMostSigmas = 2.576;
      const double sigma_x_m = std::sqrt(last.base_from_sensor->covariance(0, 0));
      EXPECT_NEAR(last.base_from_sensor->mean.x(), truth.base_from_sensor.position_m.x(),
                  std::max(0.05, kMostSigmas * sigma_x_m))
          << "landmark " << landmark << ", " << sigma_x_m << " m stated";
    }
    for (const Drive::Moment& moment : landmark_run.moments) {
      if (!moment.result.paper_state) continue;
      const PaperEstimate& paper = *moment.result.paper_state;
      EXPECT_TRUE(paper.mean.allFinite() && paper.covariance.allFinite());
      const double rho = paper.mean(PaperIndex::kRho);
      const double sigma_rho = std::sqrt(paper.covariance(PaperIndex::kRho, PaperIndex::kRho));
      if (near_zero_rho) {
        EXPECT_FALSE(paper.phi_psi_determined) << "landmark " << landmark << ", rho " << rho;
      } else if (sigma_rho < rho / 3.0) {
        EXPECT_TRUE(paper.phi_psi_determined) << "landmark " << landmark;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, Mrclam, ::testing::Values("mrclam_D6R3", "mrclam_D6R4"),
                         [](const auto& set) { return std::string(set.param); });

// ---- raw ticks at 4 Hz of a tracked robot that slips ----

class Brenner : public Recordings {};

// Its tracks turn it as if they were 0.18 m apart instead of the 0.155 m that are measured.
TEST_F(Brenner, IsFiniteAndNoSurerThanRight) {
  RecordingSetup setup;
  setup.set = "brenner_lego";
  setup.odometry = "ticks.csv";
  setup.meters_per_tick = 0.000349;
  setup.wheel_separation_m = 0.155;
  setup.wheel_noise = {1e-4, 0.0};  // a centimetre in a metre: tracks
  setup.bearing_stddev_rad = 0.01;
  setup.errors.setBlock("time_offset", 0.1);
  setup.errors.setBlock("wheel_scales", 0.03);
  setup.errors.setBlock("wheel_separation", 0.1);
  const RecordedTruth truth = readTruth(setup.set);
  int answers = 0;
  for (std::int32_t landmark : landmarksOf(setup, kAnyObservations)) {
    const LandmarkRecording recording = readLandmark(setup, landmark);
    const CalibrationResult last = drive(recording, configFor(setup)).last;
    if (!last.base_from_sensor) {
      std::printf("landmark %d: %3zu observations, no answer: %s\n", landmark,
                  recording.bearings.size(), last.advice.c_str());
      continue;
    }
    ++answers;
    const MountEstimate& mount = *last.base_from_sensor;
    ASSERT_TRUE(mount.mean.allFinite() && mount.covariance.allFinite());
    const MountError error = errorOf(mount, truth);
    std::printf("landmark %d: %3zu observations, off by %.1f cm and %.2f deg, chi2 %.1f, %s: %s\n",
                landmark, recording.bearings.size(), 100.0 * error.position_m,
                error.yaw_rad / kDegree, error.chi_square, nameOf(last.state), last.advice.c_str());
    EXPECT_LE(error.chi_square, chiSquareQuantile(0.999, 3.0)) << "landmark " << landmark;
  }
  EXPECT_GE(answers, 1);
}

}  // namespace
}  // namespace bearing_calibration::core
