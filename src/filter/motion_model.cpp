#include "bearing_calibration/filter/motion_model.h"

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Corrected = CorrectedMotion<kErrorCount>;

Corrected correct(const OdometryIncrement& measured, const ErrorVector& errors, int errors_in_use) {
  Corrected motion;
  motion.start_from_end = measured.start_from_end;
  forEachBlock(
      [&](auto block, auto at) {
        decltype(block)::template correct<at.value>(motion, measured, partOf(errors, block, at));
      },
      errors_in_use);
  return motion;
}

LinearMotion linearise(const StateLayout& layout, const ErrorVector& errors,
                       const LightPositions& lights_at_end, const Corrected& corrected,
                       const Eigen::Matrix3d& covariance, const Eigen::Vector3d& error) {
  LinearMotion motion;
  motion.start_from_end = {corrected.start_from_end.position_m + error.head<2>(),
                           wrapAngle(corrected.start_from_end.yaw_rad + error.z())};
  motion.R_end_start = rotation2(-motion.start_from_end.yaw_rad);
  motion.error = error;
  motion.covariance = covariance;
  motion.errors_at = errors;
  motion.J_lights_error.resize(2 * layout.lights, 3);
  for (int i = 0; i < layout.lights; ++i) {
    motion.J_lights_error.block<2, 2>(2 * i, 0) = -motion.R_end_start;
    motion.J_lights_error.block<2, 1>(2 * i, 2) = -perpendicular(lights_at_end.col(i));
  }
  motion.J_lights_errors.noalias() =
      motion.J_lights_error.lazyProduct(corrected.J_pose_errors.leftCols(layout.errors));
  return motion;
}

}  // namespace

Corrected correctMotion(const OdometryIncrement& measured, const ErrorVector& errors) {
  return correct(measured, errors, kErrorCount);
}

LinearMotion lineariseMotion(const StateLayout& layout, const ErrorVector& errors,
                             const LightPositions& lights_at_end, const OdometryIncrement& measured,
                             const Eigen::Vector3d& error) {
  return linearise(layout, errors, lights_at_end, correct(measured, errors, layout.errors),
                   measured.covariance, error);
}

LinearMotion lineariseMotion(const StateLayout& layout, const StateVector& before,
                             const OdometryIncrement& measured) {
  const ErrorVector errors = robotErrorsOf(layout, before);
  const Corrected corrected = correct(measured, errors, layout.errors);
  const Pose2 end_from_start = corrected.start_from_end.inverse();
  LightPositions lights_at_end(2, layout.lights);
  for (int i = 0; i < layout.lights; ++i) {
    lights_at_end.col(i) = end_from_start * Eigen::Vector2d(before.segment<2>(layout.lightAt(i)));
  }
  return linearise(layout, errors, lights_at_end, corrected, measured.covariance,
                   Eigen::Vector3d::Zero());
}

void propagate(const LinearMotion& motion, StateEstimate* estimate) {
  const StateLayout& layout = estimate->layout;
  const int at = layout.lastingSize();
  const int size = 2 * layout.lights;
  StateVector& mean = estimate->mean;
  StateMatrix& P = estimate->covariance;
  for (int i = 0; i < layout.lights; ++i) {
    const int light = layout.lightAt(i);
    mean.segment<2>(light) =
        (motion.R_end_start * (mean.segment<2>(light) - motion.start_from_end.position_m)).eval();
    P.middleRows<2>(light) = (motion.R_end_start * P.middleRows<2>(light)).eval();
  }
  mean.tail(size).noalias() -= motion.J_lights_error * motion.error;
  if (layout.errors > 0) {
    const StateVector change =
        mean.segment(kMountSize, layout.errors) - motion.errors_at.head(layout.errors);
    mean.tail(size).noalias() += motion.J_lights_errors.lazyProduct(change);
    P.bottomRows(size).noalias() +=
        motion.J_lights_errors.lazyProduct(P.middleRows(kMountSize, layout.errors));
  }
  auto P_lights = P.bottomRightCorner(size, size);
  for (int i = 0; i < layout.lights; ++i) {
    auto columns = P_lights.middleCols<2>(2 * i);
    columns = (columns * motion.R_end_start.transpose()).eval();
  }
  if (layout.errors > 0) {
    P_lights.noalias() += P.block(at, kMountSize, size, layout.errors)
                              .lazyProduct(motion.J_lights_errors.transpose());
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 2 * kMostLights, 3> J_noise =
      motion.J_lights_error * motion.covariance;
  P_lights.noalias() += J_noise.lazyProduct(motion.J_lights_error.transpose());
  P.topRightCorner(at, size) = P.bottomLeftCorner(size, at).transpose();
}

void propagate(const OdometryIncrement& measured, StateEstimate* estimate) {
  propagate(lineariseMotion(estimate->layout, estimate->mean, measured), estimate);
}

}  // namespace bearing_calibration::core
