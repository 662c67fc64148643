#include "bearing_calibration/filter/mount_filter.h"

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
  explicit ChartFilter(const CartesianEstimate& start) { restart(start); }

  void predict(const OdometryIncrement& motion) override {
    state_ = propagate(state_, Chart::propagate(state_.mean, motion), motion);
  }

  AzimuthPrediction predictAzimuth() const override { return predictAzimuthOf(state_); }

  AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion) const override {
    return predictAzimuthOf(propagate(state_, Chart::propagate(state_.mean, motion), motion));
  }

  void update(double azimuth_rad, double azimuth_variance_rad2) override {
    const AzimuthModel model = Chart::azimuth(state_.mean);
    state_ = updateScalar<5>(state_, model.J_azimuth_state,
                             wrapAngle(azimuth_rad - model.azimuth_rad), azimuth_variance_rad2);
    Chart::normalise(&state_.mean);
  }

  CartesianEstimate cartesian() const override { return Chart::toCartesian(state_); }
  PaperEstimate paper() const override { return Chart::toPaper(state_); }
  void restart(const CartesianEstimate& estimate) override { state_ = Chart::from(estimate); }

 private:
  static AzimuthPrediction predictAzimuthOf(const Gaussian<5>& state) {
    const AzimuthModel model = Chart::azimuth(state.mean);
    return {model.azimuth_rad,
            (model.J_azimuth_state * state.covariance * model.J_azimuth_state.transpose()).value()};
  }

  Gaussian<5> state_;
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

}  // namespace bearing_calibration
