#include "bearing_calibration/filter/lights_state.h"

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {
namespace {

/// A light's angle out of one with the state [light, mount, errors].
template <class Row>
LightsAngle angleOf(const LightsLayout& layout, int light, double angle_rad, const Row& J) {
  LightsAngle angle{angle_rad, LightsRow::Zero(layout.size())};
  const auto errors = J.size() - (2 + kMountSize);
  angle.J_angle_state.head<kMountSize>() = J.template segment<kMountSize>(CartesianIndex::kSensorX);
  angle.J_angle_state.segment(kMountSize, errors) = J.tail(errors);
  angle.J_angle_state.segment<2>(layout.lightAt(light)) = J.template head<2>();
  return angle;
}

}  // namespace

void symmetrise(LightsMatrix* covariance) {
  *covariance = (0.5 * (*covariance + covariance->transpose())).eval();
}

Vector5 stateOf(const LightsLayout& layout, const LightsVector& state, int light) {
  Vector5 cartesian;
  cartesian << state.segment<2>(layout.lightAt(light)), state.head<kMountSize>();
  return cartesian;
}

ErrorVector errorsOf(const LightsLayout& layout, const LightsVector& state) {
  ErrorVector errors = ErrorVector::Zero();
  errors.head(layout.errors) = state.segment(kMountSize, layout.errors);
  return errors;
}

MountEstimate LightsEstimate::mount() const {
  return {mean.head<kMountSize>(), covariance.topLeftCorner<kMountSize, kMountSize>()};
}

RobotEstimate LightsEstimate::robot(int light) const {
  const int at = layout.lightAt(light);
  const int K = layout.errors;
  RobotEstimate robot;
  robot.cartesian.mean = stateOf(layout, mean, light);
  robot.cartesian.covariance << covariance.block<2, 2>(at, at),
      covariance.block<2, kMountSize>(at, 0), covariance.block<kMountSize, 2>(0, at),
      covariance.topLeftCorner<kMountSize, kMountSize>();
  robot.errors.mean = errorsOf(layout, mean);
  robot.errors.covariance.topLeftCorner(K, K) = covariance.block(kMountSize, kMountSize, K, K);
  robot.errors.cross_covariance.topLeftCorner(2, K) = covariance.block(at, kMountSize, 2, K);
  robot.errors.cross_covariance.bottomLeftCorner(kMountSize, K) =
      covariance.block(0, kMountSize, kMountSize, K);
  return robot;
}

LightsEstimate withLights(const LightsEstimate& estimate,
                          const std::vector<std::optional<int>>& lights) {
  constexpr double kAnywhere_m = 100.0;
  LightsEstimate chosen;
  chosen.layout = {estimate.layout.errors, static_cast<int>(lights.size())};
  const int lasting = chosen.layout.lightsAt();
  std::vector<std::optional<int>> places;  // in the estimate, of each number in the chosen state
  for (int i = 0; i < lasting; ++i) places.emplace_back(i);
  for (const std::optional<int>& light : lights) {
    for (int axis = 0; axis < 2; ++axis) {
      places.push_back(light ? std::optional(estimate.layout.lightAt(*light) + axis)
                             : std::nullopt);
    }
  }
  const int size = chosen.layout.size();
  chosen.mean = LightsVector::Zero(size);
  chosen.covariance = LightsMatrix::Zero(size, size);
  for (int i = 0; i < size; ++i) {
    const std::optional<int>& from = places[static_cast<std::size_t>(i)];
    if (!from) {
      chosen.covariance(i, i) = kAnywhere_m * kAnywhere_m;
      continue;
    }
    chosen.mean(i) = estimate.mean(*from);
    for (int k = 0; k < size; ++k) {
      const std::optional<int>& other = places[static_cast<std::size_t>(k)];
      if (other) chosen.covariance(i, k) = estimate.covariance(*from, *other);
    }
  }
  return chosen;
}

void addEarlier(const LastingEstimate& earlier, const ErrorPriors& priors,
                LightsEstimate* estimate) {
  addEarlier(earlier, priors, {0, kMountSize, estimate->layout.errors}, estimate->mean,
             estimate->covariance);
}

LightsMotion lineariseMotion(const LightsLayout& layout, const ErrorVector& errors,
                             const LightPositions& lights_at_end, const OdometryIncrement& measured,
                             const Eigen::Vector3d& error) {
  const CorrectedMotion<kErrorCount> corrected = correctMotion<kErrorCount>(measured, errors);
  LightsMotion motion;
  motion.start_from_end = {corrected.start_from_end.position_m + error.head<2>(),
                           wrapAngle(corrected.start_from_end.yaw_rad + error.z())};
  motion.R_end_start = rotation2(-motion.start_from_end.yaw_rad);
  motion.error = error;
  motion.covariance = measured.covariance;
  motion.errors_at = errors.head(layout.errors);
  motion.J_lights_error.resize(2 * layout.lights, 3);
  for (int i = 0; i < layout.lights; ++i) {
    motion.J_lights_error.block<2, 2>(2 * i, 0) = -motion.R_end_start;
    motion.J_lights_error.block<2, 1>(2 * i, 2) = -perpendicular(lights_at_end.col(i));
  }
  motion.J_lights_errors = motion.J_lights_error * corrected.J_pose_errors.leftCols(layout.errors);
  return motion;
}

LightsMotion lineariseMotion(const LightsLayout& layout, const LightsVector& before,
                             const OdometryIncrement& measured) {
  const ErrorVector errors = errorsOf(layout, before);
  const Pose2 end_from_start =
      correctMotion<kErrorCount>(measured, errors).start_from_end.inverse();
  LightPositions lights_at_end(2, layout.lights);
  for (int i = 0; i < layout.lights; ++i) {
    lights_at_end.col(i) = end_from_start * Eigen::Vector2d(before.segment<2>(layout.lightAt(i)));
  }
  return lineariseMotion(layout, errors, lights_at_end, measured, Eigen::Vector3d::Zero());
}

void propagate(const LightsMotion& motion, LightsEstimate* estimate) {
  const LightsLayout& layout = estimate->layout;
  const int at = layout.lightsAt();
  const int size = 2 * layout.lights;
  LightsVector& mean = estimate->mean;
  LightsMatrix& P = estimate->covariance;
  for (int i = 0; i < layout.lights; ++i) {
    const int light = layout.lightAt(i);
    mean.segment<2>(light) =
        (motion.R_end_start * (mean.segment<2>(light) - motion.start_from_end.position_m)).eval();
    P.middleRows<2>(light) = (motion.R_end_start * P.middleRows<2>(light)).eval();
  }
  mean.tail(size).noalias() -= motion.J_lights_error * motion.error;
  if (layout.errors > 0) {
    const LightsVector change = mean.segment(kMountSize, layout.errors) - motion.errors_at;
    mean.tail(size).noalias() += motion.J_lights_errors * change;
    P.bottomRows(size).noalias() +=
        motion.J_lights_errors * P.middleRows(kMountSize, layout.errors);
  }
  for (int i = 0; i < layout.lights; ++i) {
    const int light = layout.lightAt(i);
    P.middleCols<2>(light) = (P.middleCols<2>(light) * motion.R_end_start.transpose()).eval();
  }
  if (layout.errors > 0) {
    P.rightCols(size).noalias() +=
        P.middleCols(kMountSize, layout.errors) * motion.J_lights_errors.transpose();
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 2 * kMostLights, 3> J_noise =
      motion.J_lights_error * motion.covariance;
  P.block(at, at, size, size).noalias() += J_noise * motion.J_lights_error.transpose();
}

LightsAngle expectAzimuth(const LightsLayout& layout, const LightsVector& state, int light,
                          const OdometryWindow& nearby) {
  return withErrorsInUse(layout.errors, [&](auto size) {
    const ObservationModel<size.value> model = expectObservation<size.value>(
        stateOf(layout, state, light), errorsOf(layout, state), nearby);
    return angleOf(layout, light, model.azimuth_rad, model.J_azimuth_state);
  });
}

LightsAngle expectElevation(const LightsLayout& layout, const LightsVector& state, int light,
                            const OdometryWindow& nearby) {
  const ElevationModel model =
      expectElevation(stateOf(layout, state, light), errorsOf(layout, state), nearby);
  return angleOf(layout, light, model.elevation_rad, model.J_elevation_state);
}

LightsUpdate updateByAzimuth(const LightsVector& about, int light, double azimuth_rad,
                             double azimuth_variance_rad2, const OdometryWindow& nearby,
                             LightsEstimate* estimate) {
  const LightsAngle expected = expectAzimuth(estimate->layout, about, light, nearby);
  LightsUpdate update;
  update.H = expected.J_angle_state;
  update.innovation = wrapAngle(azimuth_rad - expected.angle_rad) -
                      update.H.dot((estimate->mean - about).transpose());
  const LightsVector PHt = estimate->covariance * update.H.transpose();
  update.innovation_variance = update.H.dot(PHt.transpose()) + azimuth_variance_rad2;
  update.gain = PHt / update.innovation_variance;
  estimate->mean += update.gain * update.innovation;
  // The Joseph form, as two products of rank one: (I - K H) P, then all of it times (I - K H)^T.
  LightsMatrix& P = estimate->covariance;
  P.noalias() -= update.gain * PHt.transpose();
  const LightsVector left = azimuth_variance_rad2 * update.gain - P * update.H.transpose();
  P.noalias() += left * update.gain.transpose();
  symmetrise(&P);
  return update;
}

}  // namespace bearing_calibration::core
