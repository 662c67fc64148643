#include "bearing_calibration/filter/bearing_model.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/paper_state.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

Propagation propagateCartesian(const Vector5& state, const OdometryIncrement& motion) {
  const Pose2& start_from_end = motion.start_from_end;
  const Eigen::Matrix2d R_end_start = rotation2(-start_from_end.yaw_rad);
  const Eigen::Vector2d light_in_end = R_end_start * (state.head<2>() - start_from_end.position_m);

  Propagation next{state, Matrix5::Identity(), Eigen::Matrix<double, 5, 3>::Zero()};
  next.state.head<2>() = light_in_end;
  next.J_state_state.topLeftCorner<2, 2>() = R_end_start;
  next.J_state_motion.topLeftCorner<2, 2>() = -R_end_start;
  next.J_state_motion.topRightCorner<5, 1>().head<2>() = -perpendicular(light_in_end);
  return next;
}

AzimuthModel azimuthFromCartesian(const Vector5& state) {
  const Eigen::Vector2d ray = state.head<2>() - state.segment<2>(CartesianIndex::kSensorX);
  const Eigen::RowVector2d J_direction_observation =
      perpendicular(ray).transpose() / ray.squaredNorm();
  AzimuthModel model;
  model.azimuth_rad = wrapAngle(std::atan2(ray.y(), ray.x()) - state(CartesianIndex::kSensorYaw));
  model.J_azimuth_state << J_direction_observation, -J_direction_observation, -1.0;
  return model;
}

Propagation propagatePaper(const Vector5& state, const OdometryIncrement& motion) {
  // In the frame at the light whose x axis points to the base: the base stands at (D, 0) with the
  // heading theta.
  const double theta = state(PaperIndex::kTheta);
  const Eigen::Matrix2d R_theta = rotation2(theta);
  const Eigen::Vector2d step = R_theta * motion.start_from_end.position_m;
  const Eigen::Vector2d base = Eigen::Vector2d(state(PaperIndex::kDistance), 0.0) + step;
  const double distance = base.norm();
  const Eigen::RowVector2d J_distance_base = base.transpose() / distance;
  const Eigen::RowVector2d J_direction_base =
      perpendicular(base).transpose() / (distance * distance);

  Propagation next{state, Matrix5::Identity(), Eigen::Matrix<double, 5, 3>::Zero()};
  next.state(PaperIndex::kDistance) = distance;
  next.state(PaperIndex::kTheta) =
      wrapAngle(theta + motion.start_from_end.yaw_rad - std::atan2(base.y(), base.x()));

  const Eigen::Vector2d J_base_theta = perpendicular(step);
  next.J_state_state.topLeftCorner<2, 2>() << J_distance_base.x(),
      J_distance_base.dot(J_base_theta), -J_direction_base.x(),
      1.0 - J_direction_base.dot(J_base_theta);
  next.J_state_motion.topLeftCorner<1, 2>() = J_distance_base * R_theta;
  next.J_state_motion.block<1, 2>(PaperIndex::kTheta, 0) = -J_direction_base * R_theta;
  next.J_state_motion(PaperIndex::kTheta, 2) = 1.0;
  return next;
}

AzimuthModel azimuthFromPaper(const Vector5& state) {
  const double distance = state(PaperIndex::kDistance);
  const double rho = state(PaperIndex::kRho);
  const double heading = state(PaperIndex::kTheta) + state(PaperIndex::kPhi);
  const double s = std::sin(heading);
  const double c = std::cos(heading);
  const double gamma = distance * distance + 2.0 * distance * rho * c + rho * rho;
  const double J_azimuth_heading = -distance * (distance + rho * c) / gamma;

  AzimuthModel model;
  model.azimuth_rad =
      wrapAngle(std::atan2(-rho * s, -distance - rho * c) - heading - state(PaperIndex::kPsi));
  model.J_azimuth_state << -rho * s / gamma, J_azimuth_heading, J_azimuth_heading,
      distance * s / gamma, -1.0;
  return model;
}

}  // namespace bearing_calibration::core
