#include "bearing_calibration/filter/bearing_model.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core {
namespace {

CorrectedLight<kErrorCount> correctLight(const Eigen::Vector2d& light_in_base,
                                         const ErrorVector& errors, const OdometryWindow& nearby,
                                         int errors_in_use) {
  CorrectedLight<kErrorCount> light;
  light.in_base = light_in_base;
  WheelFactors wheels;
  forEachBlock(
      [&](auto block, auto at) { decltype(block)::addTo(wheels, partOf(errors, block, at)); },
      errors_in_use);
  forEachBlock(
      [&](auto block, auto at) {
        decltype(block)::template correct<at.value>(light, nearby, wheels,
                                                    partOf(errors, block, at));
      },
      errors_in_use);
  return light;
}

/// A light as a sensor without errors sees it at the moment of a bearing.
struct Ideal {
  CorrectedLight<kErrorCount> light;
  Eigen::Vector2d ray;  ///< from the sensor to the light
  AzimuthModel azimuth;
};

Ideal seeIdeally(const Vector5& state, const ErrorVector& errors, const OdometryWindow& nearby,
                 int errors_in_use) {
  Ideal ideal;
  ideal.light = correctLight(state.head<2>(), errors, nearby, errors_in_use);
  Vector5 at_moment = state;
  at_moment.head<2>() = ideal.light.in_base;
  ideal.ray = ideal.light.in_base - state.segment<2>(CartesianIndex::kSensorX);
  ideal.azimuth = azimuthFromCartesian(at_moment);
  return ideal;
}

/// What the blocks of the sensor make of an angle, from the last of them to the first.
template <class Corrected>
Corrected bend(const Ideal& ideal, const ErrorVector& errors, int errors_in_use, int light) {
  Corrected angle;
  angle.light = light;
  angle.azimuth_rad = ideal.azimuth.azimuth_rad;
  angle.range_m = ideal.ray.norm();
  constexpr bool kBackwards = true;
  forEachBlock(
      [&](auto block, auto at) {
        decltype(block)::template correct<at.value>(angle, partOf(errors, block, at));
      },
      errors_in_use, kBackwards);
  return angle;
}

/// An angle with its Jacobian by the state, from those by what an ideal sensor sees.
ExpectedAngle angleOf(const StateLayout& layout, int light, const Ideal& ideal, double angle_rad,
                      double J_angle_ideal, double J_angle_range,
                      const Eigen::Matrix<double, 1, kErrorCount>& J_angle_errors) {
  const Eigen::RowVector2d J_angle_ray = J_angle_ideal * ideal.azimuth.J_azimuth_state.head<2>() +
                                         J_angle_range * ideal.ray.transpose() / ideal.ray.norm();
  ExpectedAngle angle{angle_rad, StateRow::Zero(layout.size())};
  StateRow& J = angle.J_angle_state;
  J.head<kMountSize>() << -J_angle_ray, -J_angle_ideal;
  J.segment(kMountSize, layout.errors) =
      J_angle_ray.lazyProduct(ideal.light.J_light_errors.leftCols(layout.errors)) +
      J_angle_errors.head(layout.errors);
  J.segment<2>(layout.lightAt(light)) = J_angle_ray * ideal.light.J_light_light;
  return angle;
}

/// So many errors, from the first on, are not zero.
int presentErrors(const ErrorVector& errors) {
  int present = 0;
  forEachBlock([&](auto block, auto at) {
    if (!partOf(errors, block, at).isZero(0.0)) present = at.value + decltype(block)::kSize;
  });
  return present;
}

}  // namespace

AzimuthModel azimuthFromCartesian(const Vector5& state) {
  const Eigen::Vector2d ray = state.head<2>() - state.segment<2>(CartesianIndex::kSensorX);
  const Eigen::RowVector2d J_direction_ray = perpendicular(ray).transpose() / ray.squaredNorm();
  AzimuthModel model;
  model.azimuth_rad = wrapAngle(std::atan2(ray.y(), ray.x()) - state(CartesianIndex::kSensorYaw));
  model.J_azimuth_state << J_direction_ray, -J_direction_ray, -1.0;
  return model;
}

ExpectedAngle expectAzimuth(const StateLayout& layout, const StateVector& state, int light,
                            const OdometryWindow& nearby) {
  const ErrorVector errors = robotErrorsOf(layout, state);
  const Ideal ideal = seeIdeally(cartesianOf(layout, state, light), errors, nearby, layout.errors);
  const auto azimuth = bend<CorrectedAzimuth<kErrorCount>>(ideal, errors, layout.errors, light);
  return angleOf(layout, light, ideal, wrapAngle(azimuth.azimuth_rad), azimuth.J_azimuth_ideal,
                 azimuth.J_azimuth_range, azimuth.J_azimuth_errors);
}

ExpectedAngle expectElevation(const StateLayout& layout, const StateVector& state, int light,
                              const OdometryWindow& nearby) {
  const ErrorVector errors = robotErrorsOf(layout, state);
  const Ideal ideal = seeIdeally(cartesianOf(layout, state, light), errors, nearby, layout.errors);
  const auto elevation = bend<CorrectedElevation<kErrorCount>>(ideal, errors, layout.errors, light);
  return angleOf(layout, light, ideal, elevation.elevation_rad, elevation.J_elevation_ideal,
                 elevation.J_elevation_range, elevation.J_elevation_errors);
}

ScalarUpdate prepareUpdate(const StateRow& H, double residual, double variance,
                           const StateEstimate& estimate) {
  ScalarUpdate update{
      H.transpose(), estimate.covariance.lazyProduct(H.transpose()), variance, {residual, 0.0}};
  update.innovation.variance = update.H.dot(update.gain) + variance;
  update.gain /= update.innovation.variance;
  return update;
}

void apply(const ScalarUpdate& update, StateEstimate* estimate) {
  const StateVector& K = update.gain;
  StateMatrix& P = estimate->covariance;
  estimate->mean += K * update.innovation.residual;
  // (I - K H) P (I - K H)^T + K R K^T, multiplied out: in the square of the states, not their cube
  for (Eigen::Index i = 0; i < K.size(); ++i) P.col(i) -= update.innovation.variance * K(i) * K;
  const StateVector left = update.variance * K - P.lazyProduct(update.H);
  for (Eigen::Index i = 0; i < K.size(); ++i) P.col(i) += K(i) * left;
  symmetrise(&P);
}

double residualOf(const Observation& observation, const Vector5& state, const ErrorVector& errors) {
  const int present = presentErrors(errors);
  const Ideal ideal = seeIdeally(state, errors, observation.nearby, present);
  return wrapAngle(
      observation.azimuth_rad -
      bend<CorrectedAzimuth<kErrorCount>>(ideal, errors, present, observation.light).azimuth_rad);
}

std::optional<double> elevationResidualOf(const Observation& observation, const Vector5& state,
                                          const ErrorVector& errors) {
  if (!observation.elevation) return std::nullopt;
  const Ideal ideal = seeIdeally(state, errors, observation.nearby, kErrorCount);
  const auto elevation =
      bend<CorrectedElevation<kErrorCount>>(ideal, errors, kErrorCount, observation.light);
  return observation.elevation->angle_rad - elevation.elevation_rad;
}

Pose2 stampFromMoment(const Observation& observation, const ErrorVector& errors) {
  // where the base's own origin lies, seen from the moment, is all that it takes
  const auto origin =
      correctLight(Eigen::Vector2d::Zero(), errors, observation.nearby, kErrorCount);
  const Eigen::Matrix2d& R = origin.J_light_light;
  return Pose2{origin.in_base, std::atan2(R(1, 0), R(0, 0))}.inverse();
}

std::vector<Observation> withoutErrors(const std::vector<Observation>& observations,
                                       const ErrorVector& errors) {
  std::vector<Observation> corrected = observations;
  Pose2 last;
  for (Observation& observation : corrected) {
    const Pose2 stamp_from_moment = stampFromMoment(observation, errors);
    const Pose2 motion = correctMotion(observation.motion, errors).start_from_end;
    observation.motion.start_from_end = last.inverse() * motion * stamp_from_moment;
    last = stamp_from_moment;
  }
  return corrected;
}

}  // namespace bearing_calibration::core
