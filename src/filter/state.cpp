#include "bearing_calibration/filter/state.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {

template <>
const char EigenAlignedTo<EIGEN_MAX_STATIC_ALIGN_BYTES>::kAsInTheCore = 0;

Vector5 cartesianOf(const StateLayout& layout, const StateVector& state, int light) {
  Vector5 cartesian;
  cartesian << state.segment<2>(layout.lightAt(light)), state.head<kMountSize>();
  return cartesian;
}

ErrorVector robotErrorsOf(const StateLayout& layout, const StateVector& state) {
  ErrorVector errors = ErrorVector::Zero();
  errors.head(layout.errors) = state.segment(kMountSize, layout.errors);
  return errors;
}

StateEstimate StateEstimate::zero(const StateLayout& layout) {
  return {layout, StateVector::Zero(layout.size()),
          StateMatrix::Zero(layout.size(), layout.size())};
}

StateEstimate StateEstimate::of(const CartesianEstimate& cartesian, int errors,
                                const ErrorEstimate& robot) {
  StateEstimate estimate = zero({errors, 1});
  estimate.setCartesian(cartesian);
  estimate.mean.segment(kMountSize, errors) = robot.mean.head(errors);
  estimate.covariance.block(kMountSize, kMountSize, errors, errors) =
      robot.covariance.topLeftCorner(errors, errors);
  return estimate;
}

double CartesianEstimate::rangeVariance() const {
  const Eigen::Vector2d towards_light = (lightInBase() - sensorInBase()).normalized();
  Eigen::Vector4d J_range_places;  // by light and sensor
  J_range_places << towards_light, -towards_light;
  return J_range_places.dot(covariance.topLeftCorner<4, 4>() * J_range_places);
}

MountEstimate StateEstimate::mount() const {
  return {mean.head<kMountSize>(), covariance.topLeftCorner<kMountSize, kMountSize>()};
}

CartesianEstimate StateEstimate::cartesian(int light) const {
  const int at = layout.lightAt(light);
  CartesianEstimate cartesian{cartesianOf(layout, mean, light), {}};
  cartesian.covariance << covariance.block<2, 2>(at, at), covariance.block<2, kMountSize>(at, 0),
      covariance.block<kMountSize, 2>(0, at), covariance.topLeftCorner<kMountSize, kMountSize>();
  return cartesian;
}

ErrorEstimate StateEstimate::errors() const {
  const int K = layout.errors;
  ErrorEstimate errors{robotErrorsOf(layout, mean)};
  errors.covariance.topLeftCorner(K, K) = covariance.block(kMountSize, kMountSize, K, K);
  return errors;
}

void StateEstimate::setCartesian(const CartesianEstimate& cartesian, int light) {
  const int at = layout.lightAt(light);
  const Matrix5& P = cartesian.covariance;
  mean.segment<2>(at) = cartesian.mean.head<2>();
  mean.head<kMountSize>() = cartesian.mean.tail<kMountSize>();
  for (const auto& [begin, size] : {std::pair(at, 2), std::pair(0, kMountSize)}) {
    covariance.middleRows(begin, size).setZero();
    covariance.middleCols(begin, size).setZero();
  }
  covariance.block<2, 2>(at, at) = P.topLeftCorner<2, 2>();
  covariance.block<2, kMountSize>(at, 0) = P.topRightCorner<2, kMountSize>();
  covariance.block<kMountSize, 2>(0, at) = P.bottomLeftCorner<kMountSize, 2>();
  covariance.topLeftCorner<kMountSize, kMountSize>() =
      P.bottomRightCorner<kMountSize, kMountSize>();
}

void StateEstimate::wrapYaw() {
  double& yaw = mean(kMountSize - 1);
  yaw = wrapAngle(yaw);
}

StateEstimate partOf(const StateEstimate& estimate, int errors,
                     const std::vector<std::optional<int>>& lights) {
  constexpr double kAnywhere_m = 100.0;
  StateEstimate part = StateEstimate::zero({errors, static_cast<int>(lights.size())});
  std::vector<int> from;  // places in the estimate ...
  std::vector<int> to;    // ... and in the part
  constexpr int kHeights = placeOf<SensorTilt>() + SensorTilt::kHeights;
  for (int i = 0; i < kMountSize + std::min({errors, estimate.layout.errors, kHeights}); ++i) {
    from.push_back(i);
    to.push_back(i);
  }
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (lights[i] && errors > kHeights && estimate.layout.errors > kHeights) {
      from.push_back(kMountSize + kHeights + *lights[i]);
      to.push_back(kMountSize + kHeights + static_cast<int>(i));
    }
    const int at = part.layout.lightAt(static_cast<int>(i));
    for (int place = at; place < at + 2; ++place) {
      if (!lights[i]) {
        part.covariance(place, place) = kAnywhere_m * kAnywhere_m;
        continue;
      }
      from.push_back(estimate.layout.lightAt(*lights[i]) + place - at);
      to.push_back(place);
    }
  }
  for (std::size_t i = 0; i < from.size(); ++i) {
    part.mean(to[i]) = estimate.mean(from[i]);
    for (std::size_t k = 0; k < from.size(); ++k) {
      part.covariance(to[i], to[k]) = estimate.covariance(from[i], from[k]);
    }
  }
  return part;
}

StateEstimate widened(StateEstimate estimate, double widening) {
  StateVector scale = StateVector::Constant(estimate.layout.size(), std::sqrt(widening));
  scale.segment(kMountSize, estimate.layout.errors).setOnes();
  estimate.covariance = (scale.asDiagonal() * estimate.covariance * scale.asDiagonal()).eval();
  return estimate;
}

StateEstimate changedAs(StateEstimate estimate, const StateEstimate& from,
                        const StateEstimate& to) {
  const StateMatrix& before = from.covariance;
  // in standard deviations, so that metres and radians can be compared
  const StateVector unit = before.diagonal().cwiseSqrt();
  const StateVector per_unit = (unit.array() > 0.0).select(unit.cwiseInverse(), 0.0);
  const SymmetricEigen axes =
      eigenOf(per_unit.asDiagonal() * (to.covariance - before) * per_unit.asDiagonal());
  const StateMatrix directions = unit.asDiagonal() * axes.vectors;
  estimate.mean += to.mean - from.mean;
  estimate.wrapYaw();
  estimate.covariance +=
      directions * axes.values.cwiseMax(0.0).asDiagonal() * directions.transpose();
  return estimate;
}

Eigen::Vector3d mountDifference(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a.x() - b.x(), a.y() - b.y(), wrapAngle(a.z() - b.z())};
}

}  // namespace bearing_calibration::core
