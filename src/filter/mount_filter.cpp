#include "bearing_calibration/filter/mount_filter.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration::core {
namespace {

/// The filter on the Cartesian state and the robot's first K errors.
template <int K>
class CartesianFilter : public MountFilter {
 public:
  explicit CartesianFilter(const RobotEstimate& start) { restart(start); }
  std::unique_ptr<MountFilter> clone() const override {
    return std::make_unique<CartesianFilter>(*this);
  }

  void predict(const OdometryIncrement& motion) override { state_ = after(motion); }

  AzimuthPrediction predictAzimuth(const OdometryWindow& nearby) const override {
    return predictAzimuthOf(state_, nearby);
  }

  AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion,
                                        const OdometryWindow& nearby) const override {
    return predictAzimuthOf(after(motion), nearby);
  }

  void update(double azimuth_rad, double azimuth_variance_rad2, const OdometryWindow& nearby,
              const std::optional<Elevation>& elevation) override {
    const ObservationModel<K> model = observationOf(state_, nearby);
    state_ = updateScalar<5 + K>(state_, model.J_azimuth_state,
                                 wrapAngle(azimuth_rad - model.azimuth_rad), azimuth_variance_rad2);
    if constexpr (K == kErrorCount) {
      if (elevation) updateByElevation(*elevation, nearby);
    }
    state_.mean(CartesianIndex::kSensorYaw) = wrapAngle(state_.mean(CartesianIndex::kSensorYaw));
  }

  CartesianEstimate cartesian() const override { return robot().cartesian; }
  PaperEstimate paper() const override { return paperFromCartesian(cartesian()); }
  RobotEstimate robot() const override { return RobotEstimate::from<K>(state_); }
  void restart(const RobotEstimate& estimate) override { state_ = estimate.joint<K>(); }

 private:
  using State = Gaussian<5 + K>;

  /// Huber's weight: an unlikely elevation counts as one of so much larger a variance that it pulls
  /// by the limit.
  void updateByElevation(const Elevation& elevation, const OdometryWindow& nearby) {
    constexpr double kLimitSigmas = 2.5;
    const ElevationModel model =
        expectElevation(state_.mean.template head<5>(), errorsOf(state_), nearby);
    const double residual = elevation.angle_rad - model.elevation_rad;
    const double expected_variance =
        (model.J_elevation_state * state_.covariance * model.J_elevation_state.transpose()).value();
    const double variance = expected_variance + elevation.variance_rad2;
    const double doubt = std::max(1.0, std::abs(residual) / (kLimitSigmas * std::sqrt(variance)));
    state_ = updateScalar<5 + K>(state_, model.J_elevation_state, residual,
                                 doubt * variance - expected_variance);
  }

  static ErrorVector errorsOf(const State& state) {
    ErrorVector errors = ErrorVector::Zero();
    errors.head<K>() = state.mean.template tail<K>();
    return errors;
  }

  State after(const OdometryIncrement& measured) const {
    const CorrectedMotion<K> corrected = correctMotion<K>(measured, errorsOf(state_));
    OdometryIncrement motion = measured;
    motion.start_from_end = corrected.start_from_end;
    const Propagation step = propagateCartesian(state_.mean.template head<5>(), motion);
    const Eigen::Matrix<double, 2, 3> J_light_motion = step.J_state_motion.topRows<2>();
    State next = state_;
    next.mean.template head<5>() = step.state;
    propagateCovariance<K>(
        step.J_state_state.topLeftCorner<2, 2>(), J_light_motion * corrected.J_pose_errors,
        J_light_motion * motion.covariance * J_light_motion.transpose(), next.covariance);
    return next;
  }

  static ObservationModel<K> observationOf(const State& state, const OdometryWindow& nearby) {
    return expectObservation<K>(state.mean.template head<5>(), errorsOf(state), nearby);
  }

  static AzimuthPrediction predictAzimuthOf(const State& state, const OdometryWindow& nearby) {
    const ObservationModel<K> model = observationOf(state, nearby);
    return {model.azimuth_rad,
            (model.J_azimuth_state * state.covariance * model.J_azimuth_state.transpose()).value()};
  }

  State state_;
};

}  // namespace

Innovation AzimuthPrediction::innovationOf(double measured_azimuth_rad,
                                           double measured_variance_rad2) const {
  return {wrapAngle(measured_azimuth_rad - azimuth_rad), variance_rad2 + measured_variance_rad2};
}

std::unique_ptr<MountFilter> makeCartesianFilter(const RobotEstimate& start, int errors_in_use) {
  return withErrorsInUse(errors_in_use, [&](auto size) -> std::unique_ptr<MountFilter> {
    return std::make_unique<CartesianFilter<size.value>>(start);
  });
}

}  // namespace bearing_calibration::core
