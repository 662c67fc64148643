// Motion and bearing models: Jacobians against numerical differentiation on the manifold, and the
// two charts against each other and against plain geometry, at seeded states and at hard places.
#include "bearing_calibration/filter/bearing_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/filter/paper_filter.h"
#include "support/numerical_jacobian.h"

namespace bearing_calibration::core {
namespace {

using testing::largestDifference;
using testing::numericalJacobian;

constexpr int kStates = 200;
constexpr double kJacobianTolerance = 1e-6;  // of a central difference with a step of 1e-6

struct Case {
  Vector5 paper;  ///< [D, theta, phi, rho, psi]
  OdometryIncrement motion;
};

OdometryIncrement incrementOf(double x, double y, double yaw) {
  OdometryIncrement increment;
  increment.start_from_end = {{x, y}, yaw};
  return increment;
}

std::vector<Case> cases() {
  std::mt19937_64 random(20060515);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto angle = [&] { return kPi * (2.0 * unit(random) - 1.0); };
  std::vector<Case> cases;
  for (int i = 0; i < kStates; ++i) {
    Case c;
    c.paper << 0.5 + 9.5 * unit(random), angle(), angle(), 0.4 * unit(random), angle();
    c.motion = incrementOf(0.2 * unit(random) - 0.1, 0.02 * unit(random) - 0.01, angle());
    cases.push_back(c);
  }
  constexpr double kAlmostPi = kPi - 1e-9;
  for (double rho : {0.0, 1e-12, 1e-6, 0.07}) {
    for (double theta : {-kAlmostPi, 0.0, 0.5 * kPi, kAlmostPi}) {
      for (double phi : {-kAlmostPi, kAlmostPi}) {
        Case c;
        c.paper << 1.0, theta, phi, rho, -0.5 * kPi;
        c.motion = incrementOf(0.05, -0.001, kAlmostPi);
        cases.push_back(c);
      }
    }
  }
  return cases;
}

Vector5 cartesianOf(const Vector5& paper) { return cartesianFromPaper({paper}).mean; }

TEST(PaperModel, BearingJacobianAgreesWithDifferences) {
  for (const Case& c : cases()) {
    const auto azimuth = [](const Vector5& X) {
      return Eigen::Matrix<double, 1, 1>(azimuthFromPaper(X).azimuth_rad);
    };
    const auto numerical = numericalJacobian<1, 5>(azimuth, c.paper, {0});
    EXPECT_LT(largestDifference(azimuthFromPaper(c.paper).J_azimuth_state, numerical),
              kJacobianTolerance)
        << "X = " << c.paper.transpose();
  }
}

TEST(CartesianModel, BearingJacobianAgreesWithDifferences) {
  for (const Case& c : cases()) {
    const Vector5 state = cartesianOf(c.paper);
    const auto azimuth = [](const Vector5& s) {
      return Eigen::Matrix<double, 1, 1>(azimuthFromCartesian(s).azimuth_rad);
    };
    const auto numerical = numericalJacobian<1, 5>(azimuth, state, {0});
    EXPECT_LT(largestDifference(azimuthFromCartesian(state).J_azimuth_state, numerical),
              kJacobianTolerance)
        << "state = " << state.transpose();
  }
}

Eigen::Vector3d vectorOf(const Pose2& pose) {
  return {pose.position_m.x(), pose.position_m.y(), pose.yaw_rad};
}

TEST(PaperModel, MotionJacobiansAgreeWithDifferences) {
  for (const Case& c : cases()) {
    const PaperPropagation step = propagatePaper(c.paper, c.motion);
    const auto by_state = [&](const Vector5& X) { return propagatePaper(X, c.motion).state; };
    const auto by_motion = [&](const Eigen::Vector3d& m) {
      return propagatePaper(c.paper, incrementOf(m.x(), m.y(), m.z())).state;
    };
    const auto J_state = numericalJacobian<5, 5>(by_state, c.paper, {1, 2, 4});
    const auto J_motion =
        numericalJacobian<5, 3>(by_motion, vectorOf(c.motion.start_from_end), {1, 2, 4});
    EXPECT_LT(largestDifference(step.J_state_state, J_state), kJacobianTolerance);
    EXPECT_LT(largestDifference(step.J_state_motion, J_motion), kJacobianTolerance);
  }
}

Eigen::Vector2d lightAfter(const OdometryIncrement& motion, const Vector5& state) {
  StateEstimate estimate = StateEstimate::of({state, Matrix5::Zero()});
  propagate(motion, &estimate);
  return estimate.mean.tail<2>();
}

// A light moves against the base, and nothing else moves.
TEST(CartesianModel, MotionJacobiansAgreeWithDifferences) {
  for (const Case& c : cases()) {
    const Vector5 state = cartesianOf(c.paper);
    const StateEstimate before = StateEstimate::of({state, Matrix5::Zero()});
    const LinearMotion step = lineariseMotion(before.layout, before.mean, c.motion);
    const auto by_light = [&](const Eigen::Vector2d& light) {
      Vector5 moved = state;
      moved.head<2>() = light;
      return lightAfter(c.motion, moved);
    };
    const auto by_motion = [&](const Eigen::Vector3d& m) {
      return lightAfter(incrementOf(m.x(), m.y(), m.z()), state);
    };
    const auto J_light = numericalJacobian<2, 2>(by_light, Eigen::Vector2d(state.head<2>()));
    const auto J_motion = numericalJacobian<2, 3>(by_motion, vectorOf(c.motion.start_from_end));
    EXPECT_LT(largestDifference(step.R_end_start, J_light), kJacobianTolerance);
    EXPECT_LT(largestDifference(Eigen::Matrix<double, 2, 3>(step.J_lights_error), J_motion),
              kJacobianTolerance);
  }
}

// The paper's (8) written out in the world frame of its figure 1: light at the origin.
TEST(BothModels, GiveTheBearingOfPlainGeometry) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> turn(-kPi, kPi);
  for (const Case& c : cases()) {
    const double direction = turn(random);  // from the light to the base, free
    const double D = c.paper(PaperIndex::kDistance);
    const double phi = c.paper(PaperIndex::kPhi);
    const double rho = c.paper(PaperIndex::kRho);
    const Pose2 world_from_base{D * Eigen::Vector2d(std::cos(direction), std::sin(direction)),
                                wrapAngle(c.paper(PaperIndex::kTheta) + direction)};
    const Pose2 base_from_sensor{rho * Eigen::Vector2d(std::cos(phi), std::sin(phi)),
                                 wrapAngle(phi + c.paper(PaperIndex::kPsi))};
    const Eigen::Vector2d light_in_sensor =
        (world_from_base * base_from_sensor).inverse() * Eigen::Vector2d::Zero();
    const double azimuth = std::atan2(light_in_sensor.y(), light_in_sensor.x());
    EXPECT_NEAR(wrapAngle(azimuthFromPaper(c.paper).azimuth_rad - azimuth), 0.0, 1e-9);
    EXPECT_NEAR(wrapAngle(azimuthFromCartesian(cartesianOf(c.paper)).azimuth_rad - azimuth), 0.0,
                1e-9);
  }
}

TEST(BothModels, MoveTheSameWay) {
  for (const Case& c : cases()) {
    const Vector5 by_paper = cartesianOf(propagatePaper(c.paper, c.motion).state);
    StateEstimate moved = StateEstimate::of({cartesianOf(c.paper), Matrix5::Zero()});
    propagate(c.motion, &moved);
    const Vector5 by_cartesian = moved.cartesian().mean;
    EXPECT_LT((by_paper - by_cartesian).head<4>().norm(), 1e-9);
    EXPECT_NEAR(wrapAngle(by_paper(4) - by_cartesian(4)), 0.0, 1e-9);
  }
}

// Two half motions give the state of the whole one, which Euler's rule in the paper's (12) does
// not.
TEST(PaperModel, MotionIsExactAndComposes) {
  for (const Case& c : cases()) {
    const PaperPropagation half = propagatePaper(c.paper, c.motion);
    const Vector5 twice = propagatePaper(half.state, c.motion).state;
    OdometryIncrement whole;
    whole.start_from_end = c.motion.start_from_end * c.motion.start_from_end;
    const Vector5 once = propagatePaper(c.paper, whole).state;
    EXPECT_NEAR(twice(0), once(0), 1e-9);
    EXPECT_NEAR(wrapAngle(twice(1) - once(1)), 0.0, 1e-9);
  }
}

// The paper's (15) as printed, by hand at one state: D = 2, theta = 90 deg, phi = 30 deg, rho =
// 0.1.
TEST(PaperModel, JacobianIsThePapers) {
  Vector5 X;
  X << 2.0, 0.5 * kPi, kPi / 6.0, 0.1, kPi / 6.0;
  const double s = std::sqrt(3.0) / 2.0;  // sin(120 deg)
  const double c = -0.5;                  // cos(120 deg)
  const double gamma = 4.0 + 0.4 * c + 0.01;
  Eigen::Matrix<double, 1, 5> expected;
  expected << -0.1 * s, -0.2 * c - 4.0, -0.2 * c - 4.0, 2.0 * s, -gamma;
  EXPECT_LT(largestDifference(azimuthFromPaper(X).J_azimuth_state, expected / gamma), 1e-12);
}

TEST(Charts, RoundTripKeepsMeanAndCovariance) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  for (const Case& c : cases()) {
    if (c.paper(PaperIndex::kRho) < 0.01) continue;  // phi has no linear meaning there
    Matrix5 root;
    for (int i = 0; i < root.size(); ++i) root(i) = 1e-3 * normal(random);
    const PaperEstimate paper{c.paper, root * root.transpose(), false};
    const PaperEstimate back = paperFromCartesian(cartesianFromPaper(paper));
    for (int i = 0; i < 5; ++i) {
      const bool is_length = i == PaperIndex::kDistance || i == PaperIndex::kRho;
      const double difference = back.mean(i) - paper.mean(i);
      EXPECT_NEAR(is_length ? difference : wrapAngle(difference), 0.0, 1e-9) << "entry " << i;
    }
    EXPECT_LT((back.covariance - paper.covariance).norm(), 1e-9 * paper.covariance.norm() + 1e-15);
  }
}

TEST(Charts, JacobianAgreesWithDifferences) {
  for (const Case& c : cases()) {
    if (c.paper(PaperIndex::kRho) < 0.01) continue;
    const auto paper_of = [](const Vector5& s) {
      return paperFromCartesian({s, Matrix5::Zero()}).mean;
    };
    const Vector5 state = cartesianOf(c.paper);
    const Matrix5 J = numericalJacobian<5, 5>(paper_of, state, {1, 2, 4});
    constexpr double kVariance = 1e-8;  // small enough for the cap on phi to stay off
    const Matrix5 covariance =
        paperFromCartesian({state, kVariance * Matrix5::Identity()}).covariance;
    EXPECT_LT(largestDifference(covariance / kVariance, J * J.transpose()), 1e-4)
        << "X = " << c.paper.transpose();
  }
}

TEST(Charts, NothingIsNaNAtRhoZeroAndPhiIsFlagged) {
  CartesianEstimate estimate;
  estimate.mean << 2.0, 1.0, 0.0, 0.0, 0.3;
  estimate.covariance = 1e-4 * Matrix5::Identity();
  const PaperEstimate paper = paperFromCartesian(estimate);
  EXPECT_TRUE(paper.mean.allFinite());
  EXPECT_TRUE(paper.covariance.allFinite());
  EXPECT_FALSE(paper.phi_psi_determined);
  // nothing is known of a direction: the variance of a uniform one
  EXPECT_NEAR(paper.covariance(2, 2), kPi * kPi / 3.0, 1e-9);
}

TEST(Charts, PhiIsDeterminedFromThreeSigmasOn) {
  CartesianEstimate estimate;
  estimate.mean << 1.0, 0.0, 0.0299, 0.0, 0.0;
  estimate.covariance = 1e-4 * Matrix5::Identity();
  EXPECT_FALSE(paperFromCartesian(estimate).phi_psi_determined);
  estimate.mean(CartesianIndex::kSensorX) = 0.0301;
  EXPECT_TRUE(paperFromCartesian(estimate).phi_psi_determined);
}

}  // namespace
}  // namespace bearing_calibration::core
