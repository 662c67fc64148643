#include "bearing_calibration/filter/paper_filter.h"

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration::core {
namespace {

Gaussian<5> paperState(const CartesianEstimate& cartesian) {
  const PaperEstimate paper = paperFromCartesian(cartesian);
  return {paper.mean, paper.covariance};
}

class PaperFilter : public MountFilter {
 public:
  explicit PaperFilter(const CartesianEstimate& start) : ekf_(paperState(start)) {}
  std::unique_ptr<MountFilter> clone() const override {
    return std::make_unique<PaperFilter>(*this);
  }

  void predict(const OdometryIncrement& motion) override { ekf_.predict(motion); }

  AzimuthPrediction predictAzimuth(const OdometryWindow& /*nearby*/) const override {
    return ekf_.predictAzimuth();
  }

  AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion,
                                        const OdometryWindow& /*nearby*/) const override {
    PaperEkf after = ekf_;
    after.predict(motion);
    return after.predictAzimuth();
  }

  void update(double azimuth_rad, double azimuth_variance_rad2, const OdometryWindow& /*nearby*/,
              const std::optional<Elevation>& /*elevation*/) override {
    ekf_.update(azimuth_rad, azimuth_variance_rad2);
  }

  CartesianEstimate cartesian() const override {
    return cartesianFromPaper({ekf_.state().mean, ekf_.state().covariance});
  }

  /// A negative D or rho, which an update may lead to, is the same place seen from the other side:
  /// the way through the Cartesian state gives it its usual name.
  PaperEstimate paper() const override {
    const Gaussian<5>& state = ekf_.state();
    const double rho = state.mean(PaperIndex::kRho);
    if (rho < 0.0 || state.mean(PaperIndex::kDistance) < 0.0) {
      return paperFromCartesian(cartesian());
    }
    const double rho_variance = state.covariance(PaperIndex::kRho, PaperIndex::kRho);
    return {state.mean, state.covariance, isRhoDetermined(rho, rho_variance)};
  }

  RobotEstimate robot() const override { return {cartesian(), {}}; }
  void restart(const RobotEstimate& estimate) override {
    ekf_ = PaperEkf(paperState(estimate.cartesian));
  }

 private:
  PaperEkf ekf_;
};

}  // namespace

/// A motion changes D and theta alone, and by themselves alone.
void PaperEkf::predict(const OdometryIncrement& motion) {
  const Propagation step = propagatePaper(state_.mean, motion);
  const Eigen::Matrix<double, 2, 3> G = step.J_state_motion.topRows<2>();
  state_.mean = step.state;
  propagateCovariance<0>(step.J_state_state.topLeftCorner<2, 2>(), {},
                         G * motion.covariance * G.transpose(), state_.covariance);
}

AzimuthPrediction PaperEkf::predictAzimuth() const {
  const AzimuthModel model = azimuthFromPaper(state_.mean);
  return {model.azimuth_rad,
          (model.J_azimuth_state * state_.covariance * model.J_azimuth_state.transpose()).value()};
}

void PaperEkf::update(double azimuth_rad, double azimuth_variance_rad2) {
  const AzimuthModel model = azimuthFromPaper(state_.mean);
  state_ = updateScalar<5>(state_, model.J_azimuth_state,
                           wrapAngle(azimuth_rad - model.azimuth_rad), azimuth_variance_rad2);
  for (int angle : {PaperIndex::kTheta, PaperIndex::kPhi, PaperIndex::kPsi}) {
    state_.mean(angle) = wrapAngle(state_.mean(angle));
  }
}

std::unique_ptr<MountFilter> makePaperFilter(const CartesianEstimate& start) {
  return std::make_unique<PaperFilter>(start);
}

}  // namespace bearing_calibration::core
