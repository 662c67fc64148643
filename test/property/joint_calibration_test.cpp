// What several lights say of one mount together, from answers that each has given by itself.

#include "bearing_calibration/calibration/joint_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "bearing_calibration/calibration/several_lights.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/formatted.h"
#include "tools/study/default_calibration.h"
#include "tools/study/lights_case.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

/// A drive with lights that have numbers, and what each of them says by itself.
class SeparateAnswers {
 public:
  SeparateAnswers(int lights, double duration_s, double turned_rad = 0.0)
      : simulated_(paperCase(6)) {
    simulated_.duration_s = duration_s;
    simulated_.robot.base_from_sensor.yaw_rad += turned_rad;
    addLights(simulated_, lights, 6);
    simulated_.robot.sensor.identifies_lights = true;
    const ObservationRun run = simulate(simulated_);
    images = imagesOf(run, run.observations.size());
    lights_in_base = LightPositions(2, lights);
    for (int i = 0; i < lights; ++i) {
      const auto light = static_cast<std::size_t>(i);
      const std::vector<Observation> observations = observationsOf(images, {light});
      Vector5 truth = run.truth.back();
      truth.head<2>() = run.world_from_base.back().inverse() * simulated_.lights[light].position_m;
      LandmarkSolution answer;
      for (const Observation& each : observations) answer.stamps.push_back(each.stamp);
      answer.fit = BatchEstimator(config().initializer.batch)
                       .estimate(observations, {truth, observations.size() - 1});
      EXPECT_TRUE(answer.fit.converged);
      answer.average = answer.fit.last;
      lights_in_base.col(i) = truth.head<2>();
      answers_.push_back(answer);
    }
  }

  CalibratorConfig config() const {
    const EncoderConfig& encoders = simulated_.robot.encoders;
    return defaultCalibration(encoders.drive, encoders.noise);
  }

  std::vector<const LandmarkSolution*> answers() const {
    std::vector<const LandmarkSolution*> answers;
    for (const LandmarkSolution& answer : answers_) answers.push_back(&answer);
    return answers;
  }

  /// @param sound  so many of the lights have an answer, the first ones
  JointCalibration reviewedBy(const CalibratorConfig& config,
                              std::size_t sound = kMostLights) const {
    std::vector<const LandmarkSolution*> given = answers();
    for (std::size_t i = sound; i < given.size(); ++i) given[i] = nullptr;
    JointCalibration joint(config);
    for (const LightsImage& image : images) joint.add(image);
    joint.review(given, lights_in_base, std::nullopt);
    return joint;
  }

  /// What the first light has said by itself, farther ahead by so many of its standard deviations.
  void moveFirstAnswer(double sigmas) {
    StateEstimate& average = answers_.front().average;
    average.mean(0) =
        answers_.front().fit.last.mean(0) + sigmas * std::sqrt(average.covariance(0, 0));
  }

  /// Each light's answer supposes a slip of the wheels then.
  void supposeSlipAt(std::size_t observation) {
    for (LandmarkSolution& answer : answers_) answer.fit.slips = {observation};
  }

  std::vector<LightsImage> images;
  LightPositions lights_in_base;  ///< at the last image

 private:
  SimulatedCase simulated_;
  std::vector<LandmarkSolution> answers_;
};

TEST(JointCalibration, SaysTheLargerStandardDeviationOfThePosition) {
  const SeparateAnswers drive(2, 8.0);  // it has hardly turned
  CalibratorConfig config = drive.config();
  config.converged.position_stddev_m = 1e-4;  // farther off than it can be known by then
  const JointCalibration calibration = drive.reviewedBy(config);
  ASSERT_EQ(calibration.outcome(), JointCalibration::Outcome::kJoint);
  const auto& joint = calibration.joint();
  const Eigen::Matrix3d covariance = joint->filter.estimate().mount().covariance;
  const double x_m = std::sqrt(covariance(0, 0));
  const double y_m = std::sqrt(covariance(1, 1));
  ASSERT_GT(std::abs(x_m - y_m), 1e-3) << "both alike";
  const std::string position = formatted("position known to %.3f m", std::max(x_m, y_m));
  EXPECT_NE(joint->judgement.advice.find(position), std::string::npos) << joint->judgement.advice;
}

// The oldest part is given away up to an image that no slip is near; one that is long ago does not
// matter.
TEST(JointCalibration, AFullRecordGivesItsOldestPartAwayThoughTheWheelsHaveSlipped) {
  SeparateAnswers drive(2, 40.0);
  drive.supposeSlipAt(20);
  CalibratorConfig config = drive.config();
  config.initializer.record.capacity = drive.images.size() + 10;
  const JointCalibration calibration = drive.reviewedBy(config);
  ASSERT_EQ(calibration.outcome(), JointCalibration::Outcome::kJoint);
  EXPECT_GT(calibration.since(), drive.images[30].stamp);
}

// The one that is farther from what they say together decides, not the one that is nearer.
TEST(JointCalibration, IsNotConvergedWhereOneOfTwoDoesNotQuiteAgree) {
  SeparateAnswers drive(2, 40.0);
  CalibratorConfig config = drive.config();
  config.converged.position_stddev_m = config.converged.yaw_stddev_rad = 1.0;
  int converged = 0;
  int in_doubt = 0;
  for (double sigmas = 0.0; sigmas < 6.0; sigmas += 0.25) {
    drive.moveFirstAnswer(sigmas);
    const JointCalibration calibration = drive.reviewedBy(config);
    if (calibration.outcome() != JointCalibration::Outcome::kJoint) continue;
    const Judgement& judgement = calibration.joint()->judgement;
    if (judgement.state == CalibrationState::kConverged) ++converged;
    in_doubt += judgement.advice.find("do not quite agree") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(converged, 0);
  EXPECT_GT(in_doubt, 0);
}

// All of it is another mount than the one that was claimed: it counts after so much more motion.
TEST(JointCalibration, ALeapOfTheMountIsConfirmedFirst) {
  const SeparateAnswers drive(2, 40.0);
  SeparateAnswers moved(2, 40.0, 0.1);
  JointCalibration calibration = drive.reviewedBy(drive.config());
  ASSERT_EQ(calibration.joint()->judgement.state, CalibrationState::kConverged);
  for (const std::size_t light : {0, 1}) calibration.forget(light);
  for (LightsImage& image : moved.images) {
    image.stamp += std::chrono::seconds(100);
    calibration.add(image);
  }
  calibration.review(moved.answers(), moved.lights_in_base, std::nullopt);
  ASSERT_EQ(calibration.outcome(), JointCalibration::Outcome::kJoint);
  EXPECT_NE(calibration.joint()->judgement.advice.find("has changed by more than its uncertainty"),
            std::string::npos)
      << calibration.joint()->judgement.advice;
  LightsImage later = moved.images.back();
  later.motion.distance_m = kHeldOver_m;
  for (LightObservation& light : later.lights) light = {};
  calibration.add(later);
  later.motion.distance_m = 0.0;
  later.lights = moved.images.back().lights;
  calibration.add(later);
  calibration.review(moved.answers(), moved.lights_in_base, std::nullopt);
  EXPECT_EQ(calibration.joint()->judgement.state, CalibrationState::kConverged);
}

// The robot has driven on for two seconds, in view of another light only.
TEST(JointCalibration, StandsAtTheLastImageThoughThatShowsOthersOnly) {
  SeparateAnswers drive(3, 40.0);
  constexpr std::size_t kLast = 20;
  for (std::size_t i = drive.images.size() - kLast; i < drive.images.size(); ++i) {
    for (std::size_t light : {0, 1}) drive.images[i].lights.at(light) = {};
  }
  const JointCalibration calibration = drive.reviewedBy(drive.config(), 2);
  ASSERT_EQ(calibration.outcome(), JointCalibration::Outcome::kJoint);
  const StateEstimate& estimate = calibration.joint()->filter.estimate();
  const Eigen::Vector4d lights = estimate.mean.tail<4>();
  const Eigen::Vector4d off = lights - drive.lights_in_base.leftCols<2>().reshaped();
  const Eigen::Matrix4d covariance = estimate.covariance.bottomRightCorner<4, 4>();
  EXPECT_LT(off.dot(covariance.ldlt().solve(off)), chiSquareQuantile(0.9999, 4.0)) << off;
}

// What a light's own record still has may be given away in the common one.
TEST(JointCalibration, ASlipFromBeforeItsRecordConcernsNoneOfItsImages) {
  SeparateAnswers drive(2, 40.0);
  drive.supposeSlipAt(20);
  const std::vector<LightsImage> later(drive.images.begin() + 100, drive.images.end());
  EXPECT_TRUE(slipsOf(observationsOf(later, {0, 1}), drive.answers()).empty());
  EXPECT_EQ(slipsOf(observationsOf(drive.images, {0, 1}), drive.answers()).size(), 1U);
}

/// Numbers of the lights that it knows.
std::vector<std::int32_t> numbersOf(const SeveralLights& lights) {
  CalibrationResult result;
  lights.describe(&result);
  std::vector<std::int32_t> numbers;
  for (const LightSummary& light : result.lights) numbers.push_back(light.light_id);
  return numbers;
}

// A glimpse of something takes no light's place for ever.
TEST(SeveralLights, OneThatWasNeverFoundGivesItsPlaceToAnother) {
  CalibratorConfig config = SeparateAnswers(2, 8.0).config();
  config.max_lights = 2;
  SeveralLights lights(config);
  const auto show = [&](double at_s, std::vector<std::int32_t> numbers) {
    Frame frame;
    frame.image.stamp = stampFromSeconds(at_s);
    for (const std::int32_t number : numbers) {
      Bearing candidate;
      candidate.light_id = number;
      candidate.azimuth_rad = 0.1 * number;
      candidate.azimuth_variance_rad2 = 1e-4;
      candidate.probability = 1.0;
      frame.image.candidates.push_back(candidate);
    }
    lights.process(frame);
  };
  show(1.0, {1, 2});
  show(2.0, {2, 3});
  EXPECT_EQ(numbersOf(lights), (std::vector<std::int32_t>{1, 2}));
  for (int i = 0; i < 40; ++i) show(3.0 + i, {2, 3});
  EXPECT_EQ(numbersOf(lights), (std::vector<std::int32_t>{3, 2}));
}

// By itself it has given the same mount; then its bearings scatter ten times as much as they
// should.
TEST(JointCalibration, TheOnlyLightWhoseBearingsDoNotFitBesideTheOthersIsLeftOut) {
  for (const std::size_t noisy : {0, 1, 2}) {
    SeparateAnswers drive(3, 40.0);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (LightsImage& image : drive.images) {
      LightObservation& seen = image.lights.at(noisy);
      seen.azimuth_rad += 10.0 * std::sqrt(seen.azimuth_variance_rad2) * normal(random);
    }
    const JointCalibration calibration = drive.reviewedBy(drive.config());
    EXPECT_EQ(calibration.outcome(), JointCalibration::Outcome::kJoint);
    EXPECT_EQ(calibration.contradicting(), std::vector<std::size_t>{noisy});
    ASSERT_TRUE(calibration.joint());
    EXPECT_EQ(calibration.joint()->lights.size(), 2U);
  }
}

}  // namespace
}  // namespace bearing_calibration::core
