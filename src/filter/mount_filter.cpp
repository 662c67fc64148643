#include "bearing_calibration/filter/mount_filter.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration {
namespace {

/// In every chart a motion changes the first two entries alone, and by themselves alone: the mount
/// stays as it is. So does its covariance, which is not computed again.
Gaussian<5> propagate(const Gaussian<5>& prior, const Propagation& step,
                      const OdometryIncrement& motion) {
  const Eigen::Matrix2d F = step.J_state_state.topLeftCorner<2, 2>();
  const Eigen::Matrix<double, 2, 3> G = step.J_state_motion.topRows<2>();
  Gaussian<5> next{step.state, prior.covariance};
  next.covariance.topRightCorner<2, 3>() = F * prior.covariance.topRightCorner<2, 3>();
  next.covariance.bottomLeftCorner<3, 2>() = next.covariance.topRightCorner<2, 3>().transpose();
  next.covariance.topLeftCorner<2, 2>() =
      F * prior.covariance.topLeftCorner<2, 2>() * F.transpose() +
      G * motion.covariance * G.transpose();
  return next;
}

/// One filter for every chart: the chart says how its state moves, what bearing it gives, which of
/// its entries are angles, and how it maps to the other charts.
template <class Chart>
class ChartFilter : public MountFilter {
 public:
  explicit ChartFilter(const CartesianEstimate& start) { restart({start, {}}); }
  std::unique_ptr<MountFilter> clone() const override {
    return std::make_unique<ChartFilter>(*this);
  }

  void predict(const OdometryIncrement& motion) override { state_ = after(motion); }

  AzimuthPrediction predictAzimuth(const TravelNearby& nearby) const override {
    return predictAzimuthOf(state_, nearby);
  }

  AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion,
                                        const TravelNearby& nearby) const override {
    return predictAzimuthOf(after(motion), nearby);
  }

  void update(double azimuth_rad, double azimuth_variance_rad2, const TravelNearby& nearby,
              const std::optional<Elevation>& /*elevation*/) override {
    const AzimuthModel model = azimuthOf(state_, nearby);
    state_ = updateScalar<5>(state_, model.J_azimuth_state,
                             wrapAngle(azimuth_rad - model.azimuth_rad), azimuth_variance_rad2);
    Chart::normalise(&state_.mean);
  }

  CartesianEstimate cartesian() const override { return Chart::toCartesian(state_); }
  PaperEstimate paper() const override { return Chart::toPaper(state_); }
  RobotEstimate robot() const override { return {cartesian(), held_}; }
  void restart(const RobotEstimate& estimate) override {
    state_ = Chart::from(estimate.cartesian);
    held_ = estimate.errors;
    has_errors_ = !held_.mean.isZero(0.0);
  }

 private:
  Gaussian<5> after(const OdometryIncrement& motion) const {
    if (!has_errors_) return propagate(state_, Chart::propagate(state_.mean, motion), motion);
    OdometryIncrement corrected = motion;
    corrected.start_from_end = correctMotion<kErrorCount>(motion, held_.mean).start_from_end;
    return propagate(state_, Chart::propagate(state_.mean, corrected), corrected);
  }

  AzimuthModel azimuthOf(const Gaussian<5>& state, const TravelNearby& nearby) const {
    AzimuthModel model = Chart::azimuth(state.mean);
    if (has_errors_) {
      // errors this small move the azimuth, and hardly its Jacobian
      const Vector5 cartesian = Chart::toCartesian(state).mean;
      model.azimuth_rad = expectSight<kErrorCount>(cartesian, held_.mean, nearby).azimuth_rad;
    }
    return model;
  }

  AzimuthPrediction predictAzimuthOf(const Gaussian<5>& state, const TravelNearby& nearby) const {
    const AzimuthModel model = azimuthOf(state, nearby);
    return {model.azimuth_rad,
            (model.J_azimuth_state * state.covariance * model.J_azimuth_state.transpose()).value()};
  }

  Gaussian<5> state_;
  ErrorEstimate held_;
  bool has_errors_ = false;  ///< held_ is not zero
};

/// The filter on the Cartesian state and the robot's first K errors.
template <int K>
class RobotFilter : public MountFilter {
 public:
  explicit RobotFilter(const RobotEstimate& start) { restart(start); }
  std::unique_ptr<MountFilter> clone() const override {
    return std::make_unique<RobotFilter>(*this);
  }

  void predict(const OdometryIncrement& motion) override { state_ = after(motion); }

  AzimuthPrediction predictAzimuth(const TravelNearby& nearby) const override {
    return predictAzimuthOf(state_, nearby);
  }

  AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion,
                                        const TravelNearby& nearby) const override {
    return predictAzimuthOf(after(motion), nearby);
  }

  void update(double azimuth_rad, double azimuth_variance_rad2, const TravelNearby& nearby,
              const std::optional<Elevation>& elevation) override {
    const SightModel<K> model = sightOf(state_, nearby);
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
  void updateByElevation(const Elevation& elevation, const TravelNearby& nearby) {
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

  static SightModel<K> sightOf(const State& state, const TravelNearby& nearby) {
    return expectSight<K>(state.mean.template head<5>(), errorsOf(state), nearby);
  }

  static AzimuthPrediction predictAzimuthOf(const State& state, const TravelNearby& nearby) {
    const SightModel<K> model = sightOf(state, nearby);
    return {model.azimuth_rad,
            (model.J_azimuth_state * state.covariance * model.J_azimuth_state.transpose()).value()};
  }

  State state_;
};

struct CartesianChart {
  static Propagation propagate(const Vector5& state, const OdometryIncrement& motion) {
    return propagateCartesian(state, motion);
  }
  static AzimuthModel azimuth(const Vector5& state) { return azimuthFromCartesian(state); }
  static void normalise(Vector5* state) {
    (*state)(CartesianIndex::kSensorYaw) = wrapAngle((*state)(CartesianIndex::kSensorYaw));
  }
  static Gaussian<5> from(const CartesianEstimate& estimate) {
    return {estimate.mean, estimate.covariance};
  }
  static CartesianEstimate toCartesian(const Gaussian<5>& state) {
    return {state.mean, state.covariance};
  }
  static PaperEstimate toPaper(const Gaussian<5>& state) {
    return paperFromCartesian(toCartesian(state));
  }
};

struct PaperChart {
  static Propagation propagate(const Vector5& state, const OdometryIncrement& motion) {
    return propagatePaper(state, motion);
  }
  static AzimuthModel azimuth(const Vector5& state) { return azimuthFromPaper(state); }
  static void normalise(Vector5* state) {
    for (int angle : {PaperIndex::kTheta, PaperIndex::kPhi, PaperIndex::kPsi}) {
      (*state)(angle) = wrapAngle((*state)(angle));
    }
  }
  static Gaussian<5> from(const CartesianEstimate& estimate) {
    const PaperEstimate paper = paperFromCartesian(estimate);
    return {paper.mean, paper.covariance};
  }
  static CartesianEstimate toCartesian(const Gaussian<5>& state) {
    return cartesianFromPaper({state.mean, state.covariance});
  }
  /// A negative D or rho, which an update may lead to, is the same place seen from the other side:
  /// the way through the Cartesian chart gives it its usual name.
  static PaperEstimate toPaper(const Gaussian<5>& state) {
    const double rho = state.mean(PaperIndex::kRho);
    if (rho < 0.0 || state.mean(PaperIndex::kDistance) < 0.0) {
      return paperFromCartesian(toCartesian(state));
    }
    const double rho_variance = state.covariance(PaperIndex::kRho, PaperIndex::kRho);
    return {state.mean, state.covariance, isRhoDetermined(rho, rho_variance)};
  }
};

}  // namespace

Innovation AzimuthPrediction::innovationOf(double measured_azimuth_rad,
                                           double measured_variance_rad2) const {
  return {wrapAngle(measured_azimuth_rad - azimuth_rad), variance_rad2 + measured_variance_rad2};
}

std::unique_ptr<MountFilter> makeCartesianFilter(const CartesianEstimate& start) {
  return std::make_unique<ChartFilter<CartesianChart>>(start);
}

std::unique_ptr<MountFilter> makePaperFilter(const CartesianEstimate& start) {
  return std::make_unique<ChartFilter<PaperChart>>(start);
}

std::unique_ptr<MountFilter> makeRobotFilter(const RobotEstimate& start, int errors_in_use) {
  return withErrorsInUse(errors_in_use, [&](auto size) -> std::unique_ptr<MountFilter> {
    return std::make_unique<RobotFilter<size.value>>(start);
  });
}

}  // namespace bearing_calibration
