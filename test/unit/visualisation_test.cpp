#include "bearing_calibration/output/visualisation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "bearing_calibration/geometry/pictures.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSigmas = 3.0;

/// R diag(major^2, minor^2) R^T: its axes and their direction are known by construction.
Eigen::Matrix2d covarianceOf(double major_m, double minor_m, double direction_rad) {
  const Eigen::Matrix2d R = rotation2(direction_rad);
  return R * Eigen::Vector2d(major_m * major_m, minor_m * minor_m).asDiagonal() * R.transpose();
}

/// The ends of the major and the minor axis of an ellipse about the origin.
std::array<Eigen::Vector2d, 2> axesOf(const Eigen::Matrix2d& covariance) {
  const auto corners = ellipseOutline(covariance, kSigmas, Eigen::Vector2d::Zero(), 4);
  return {corners[0], corners[1]};
}

TEST(EllipseOutline, HasTheAxesThatTheCovarianceWasMadeOf) {
  for (double direction_rad : {0.0, 0.3, 1.2, 0.5 * kPi, 2.5, -0.7}) {
    const auto [major, minor] = axesOf(covarianceOf(0.2, 0.05, direction_rad));
    EXPECT_NEAR(major.norm(), 0.6, 1e-12);
    EXPECT_NEAR(minor.norm(), 0.15, 1e-12);
    EXPECT_NEAR(std::sin(std::atan2(major.y(), major.x()) - direction_rad), 0.0, 1e-9)
        << direction_rad;
    EXPECT_LT((minor.normalized() - perpendicular(major.normalized())).norm(), 1e-9);
  }
}

TEST(EllipseOutline, LiesAtItsMahalanobisDistanceAndIsClosed) {
  const Eigen::Matrix2d covariance = covarianceOf(0.4, 0.003, 0.8);
  const Eigen::Vector2d centre(1.5, -2.0);
  const auto outline = ellipseOutline(covariance, 2.0, centre, 32);
  ASSERT_EQ(outline.size(), 33U);
  EXPECT_EQ(outline.front(), outline.back());
  for (const Eigen::Vector2d& point : outline) {
    const Eigen::Vector2d d = point - centre;
    EXPECT_NEAR(d.dot(covariance.inverse() * d), 4.0, 1e-6);
  }
}

TEST(EllipseOutline, ARoundingErrorBelowZeroIsNoVarianceAndNaNStays) {
  const auto [major, minor] = axesOf(Eigen::Vector2d(1.0, -1e-18).asDiagonal());
  EXPECT_NEAR(major.norm(), 3.0, 1e-12);
  EXPECT_NEAR(minor.norm(), 0.0, 1e-15);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(axesOf(Eigen::Matrix2d::Constant(kNaN)).front().x()));
}

TEST(DrivenPath, KeepsItsSpacingUntilItIsFullAndTheWholeWayThen) {
  DrivenPath path(0.125, 8);  // powers of two: no rounding
  for (int i = 0; i <= 640; ++i) path.add({i / 64.0, 0.0});
  // 10 m in at most 8 points: the spacing has doubled to 2 m.
  ASSERT_EQ(path.points_m().size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(path.points_m()[i].x(), 2.0 * i);
  path.clear();
  path.add({0.0, 0.0});
  path.add({0.1, 0.0});
  path.add({0.13, 0.0});
  EXPECT_EQ(path.points_m().size(), 2U) << "it begins again with its own spacing";
}

TEST(DrivenPath, NeedsASpacingAndRoom) {
  EXPECT_THROW(DrivenPath(0.0, 10), std::invalid_argument);
  EXPECT_THROW(DrivenPath(0.1, 1), std::invalid_argument);
}

/// A calibration that knows everything, with the base somewhere in the start frame.
CalibrationResult knownResult() {
  CartesianEstimate estimate;
  estimate.mean << 2.0, 1.0, 0.1, -0.05, 0.4;
  estimate.covariance.topLeftCorner<2, 2>() = covarianceOf(0.3, 0.1, 0.2);
  estimate.covariance.block<2, 2>(2, 2) = covarianceOf(0.02, 0.01, 1.0);
  estimate.covariance(4, 4) = 0.01 * 0.01;
  CalibrationResult result;
  result.stamp = stampFromNanoseconds(5);
  result.start_from_base = {{-1.0, 0.5}, 2.0};
  result.cartesian_state = estimate;
  return result;
}

AssociationOutcome takenOutcome(double azimuth_rad, Stamp stamp) {
  AssociationOutcome outcome;
  outcome.kind = Association::Kind::kFound;
  outcome.observation.azimuth_rad = azimuth_rad;
  outcome.observation.stamp = stamp;
  return outcome;
}

TEST(Visualisation, TheRayOfAnExactBearingLeavesTheSensorAndPassesTheLight) {
  const CalibrationResult result = knownResult();
  const CartesianEstimate& estimate = *result.cartesian_state;
  const Eigen::Vector2d ray = estimate.lightInBase() - estimate.sensorInBase();
  Visualiser visualiser(kSigmas);
  visualiser.see(takenOutcome(std::atan2(ray.y(), ray.x()) - estimate.sensorYaw(), result.stamp));
  const Visualisation visualisation = visualiser.draw(result, result.start_from_base);
  ASSERT_TRUE(visualisation.found && visualisation.ray_in_start);
  const auto& [from, to] = *visualisation.ray_in_start;
  EXPECT_NEAR((from - result.start_from_base * estimate.sensorInBase()).norm(), 0.0, 1e-12);
  const Eigen::Vector2d along = (to - from).normalized();
  const Eigen::Vector2d to_light = visualisation.found->lights.at(0).in_start - from;
  EXPECT_NEAR(to_light.dot(perpendicular(along)), 0.0, 1e-12);
  EXPECT_GT((to - from).norm(), to_light.norm());
}

TEST(Visualisation, TheEllipsesAreThoseOfTheCovariancesInTheirFrames) {
  const CalibrationResult result = knownResult();
  const auto found = Visualiser(kSigmas).draw(result, result.start_from_base).found;
  ASSERT_TRUE(found.has_value());
  const Eigen::Matrix2d R = rotation2(result.start_from_base.yaw_rad);
  const Eigen::Matrix2d light_in_start =
      R * result.cartesian_state->covariance.topLeftCorner<2, 2>() * R.transpose();
  for (const Eigen::Vector2d& point : found->lights.at(0).ellipse_in_start) {
    const Eigen::Vector2d d = point - found->lights.at(0).in_start;
    EXPECT_NEAR(d.dot(light_in_start.inverse() * d), kSigmas * kSigmas, 1e-9);
  }
  const Eigen::Matrix2d sensor = result.cartesian_state->covariance.block<2, 2>(2, 2);
  for (const Eigen::Vector2d& point : found->sensor_ellipse_in_base) {
    const Eigen::Vector2d d = point - found->base_from_sensor.position_m;
    EXPECT_NEAR(d.dot(sensor.inverse() * d), kSigmas * kSigmas, 1e-9);
  }
  EXPECT_NEAR(found->sensor_yaw_band_rad, 0.03, 1e-12);
}

TEST(Visualisation, TheRayStaysWhereItWasSeenWhileTheRobotDrivesOn) {
  CalibrationResult result = knownResult();
  Visualiser visualiser(kSigmas);
  visualiser.see(takenOutcome(0.3, result.stamp));
  const auto seen = visualiser.draw(result, result.start_from_base).ray_in_start;
  AssociationOutcome gated = takenOutcome(1.0, stampFromNanoseconds(6));
  gated.kind = Association::Kind::kGated;
  visualiser.see(gated);
  result.stamp = gated.observation.stamp;
  result.start_from_base = {{3.0, 3.0}, 0.0};
  EXPECT_EQ(visualiser.draw(result, result.start_from_base).ray_in_start, seen);
  visualiser.restart();
  const Visualisation anew = visualiser.draw(result, result.start_from_base);
  EXPECT_FALSE(anew.ray_in_start);
  EXPECT_EQ(anew.path_in_start.size(), 1U);
}

TEST(Visualisation, BeforeTheFirstEstimateThereIsThePathAlone) {
  Visualiser visualiser(kSigmas);
  visualiser.see(takenOutcome(0.3, stampFromNanoseconds(5)));
  CalibrationResult result;
  result.stamp = stampFromNanoseconds(5);
  visualiser.draw(result, {});
  const Visualisation visualisation = visualiser.draw(result, {{1.0, 0.0}, 0.0});
  EXPECT_FALSE(visualisation.found || visualisation.ray_in_start);
  EXPECT_EQ(visualisation.path_in_start.size(), 2U);
}

}  // namespace
}  // namespace bearing_calibration::core
