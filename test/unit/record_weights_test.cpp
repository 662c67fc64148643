#include "bearing_calibration/solve/record_weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/filter/robust_loss.h"

namespace bearing_calibration::core {
namespace {

constexpr double kStddev_rad = 0.01;

/// A robot on a circle, and a mount and a light that it knows.
struct Record {
  std::vector<Observation> observations;
  RecordPath path;
};

Record circleOf(int images, double interval_s) {
  const Eigen::Vector2d light(2.0, 1.0);  // where the robot begins
  Record record;
  record.path.mount << 0.1, -0.05, 0.5;
  Pose2 first_from_base;
  for (int i = 0; i < images; ++i) {
    Observation observation;
    observation.stamp = stampFromSeconds(1.0 + interval_s * i);
    observation.motion = append({}, {0.02, 0.03}, 0.25, {1e-8, 0.0});
    if (i > 0) first_from_base = first_from_base * observation.motion.start_from_end;
    const Eigen::Vector2d light_in_base =
        rotation2(-first_from_base.yaw_rad) * (light - first_from_base.position_m);
    record.path.points.push_back({light_in_base});
    Vector5 state;
    state << light_in_base, record.path.mount;
    observation.azimuth_rad = azimuthFromCartesian(state).azimuth_rad;
    observation.azimuth_variance_rad2 = kStddev_rad * kStddev_rad;
    record.observations.push_back(observation);
  }
  return record;
}

std::vector<std::size_t> leftOut(const Record& record, std::size_t given_up) {
  const BatchConfig config;
  SlipHypothesis slips;
  slips.given_up = {given_up};
  const RecordWeights weights(record.observations,
                              std::vector<bool>(record.observations.size(), true), config, slips);
  std::vector<std::size_t> left_out;
  for (std::size_t i = 0; i < record.observations.size(); ++i) {
    if (!weights.observations()[i].use_bearing) left_out.push_back(i);
  }
  return left_out;
}

// On one side of a slip at least a bearing is held by a motion that is believed.
TEST(RecordWeights, ABearingBesideASlipIsUsed) {
  const Record record = circleOf(10, 1.0);  // one motion lasts longer than a slip
  EXPECT_EQ(leftOut(record, 5), std::vector<std::size_t>());
  EXPECT_EQ(leftOut(record, 9), std::vector<std::size_t>());
}

// The motions that end from 0.2 s before the slip to 0.2 s after it are not believed: to 8 to 12.
TEST(RecordWeights, ABearingBetweenTwoMotionsThatSlippedIsLeftOut) {
  EXPECT_EQ(leftOut(circleOf(20, 0.1), 10), (std::vector<std::size_t>{8, 9, 10, 11}));
}

/// Lag-1 correlation that is found in innovations of 101 bearings, one standard deviation each, of
/// which so many have the sign of the one before.
double correlationFound(std::size_t alike) {
  const Record record = circleOf(101, 0.1);
  SmootherPass pass;
  double residual = 1.0;
  for (std::size_t i = 0; i < record.observations.size(); ++i) {
    if (i > alike) residual = -residual;
    pass.observations.emplace_back().azimuth = {residual, 1.0};
  }
  const BatchConfig config;
  RecordWeights weights(record.observations, std::vector<bool>(record.observations.size(), true),
                        config, {});
  const bool is_wider = weights.widenForCorrelation(pass, record.path);
  EXPECT_EQ(is_wider, weights.correlation() > 0.0);
  return weights.correlation();
}

// White ones scatter about 0 with a standard deviation of 0.1: below two of these none is found.
TEST(RecordWeights, AreWidenedForACorrelationThatIsSignificant) {
  EXPECT_EQ(correlationFound(40), 0.0);
  EXPECT_EQ(correlationFound(57), 0.0);  // 0.14
  EXPECT_NEAR(correlationFound(62), 0.24, 1e-9);
  EXPECT_NEAR(correlationFound(80), 0.6, 1e-9);
}

/// What giving up the last motion would gain, where the last bearing is off by so much, as Huber's
/// loss with this limit weighs it.
double gainOfLastMotion(double sigmas, double huber_limit) {
  Record record = circleOf(200, 0.1);
  record.observations.back().azimuth_rad += sigmas * kStddev_rad;
  std::vector<ObservationWeight> weights;
  for (const Observation& observation : record.observations) {
    weights.push_back({observation.azimuth_variance_rad2, observation.azimuth_variance_rad2});
  }
  weights.back().bearing_variance_rad2 *= huber(sigmas, huber_limit).doubt;
  return smooth(record.observations, weights, record.path, kFreePass).observations.back().slip_gain;
}

// Huber's loss pulls with an outlier as with a bearing at its limit, however far it is off: it must
// not look like a larger slip either.
TEST(Smoother, AnOutlierLooksLikeNoLargerSlipThanABearingAtHubersLimit) {
  constexpr double kLimit = 2.0;
  const double at_limit = gainOfLastMotion(kLimit, kLimit);
  EXPECT_NEAR(at_limit, kLimit * kLimit, 0.5);  // nearly all that the bearing costs
  for (const double sigmas : {10.0, 30.0, 100.0}) {
    EXPECT_LE(gainOfLastMotion(sigmas, kLimit), at_limit) << sigmas;
    EXPECT_GT(gainOfLastMotion(sigmas, kLimit), 0.0) << sigmas;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
