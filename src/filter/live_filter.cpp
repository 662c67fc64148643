#include "bearing_calibration/filter/live_filter.h"

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/filter/robust_loss.h"

namespace bearing_calibration::core {
namespace {

double varianceOf(const StateRow& H, const StateMatrix& covariance) {
  return H.dot((covariance * H.transpose()).transpose());
}

}  // namespace

Innovation AzimuthPrediction::innovationOf(double measured_azimuth_rad,
                                           double measured_variance_rad2) const {
  return {wrapAngle(measured_azimuth_rad - azimuth_rad), variance_rad2 + measured_variance_rad2};
}

LiveFilter::LiveFilter(const StateEstimate& start, Parametrisation parametrisation)
    : parametrisation_(parametrisation), state_(start) {
  if (parametrisation == Parametrisation::kPaper)
    paper_.emplace(paperFromCartesian(start.cartesian()));
}

void LiveFilter::predict(const OdometryIncrement& motion) {
  if (paper_) return paper_->predict(motion);
  propagate(motion, &state_);
}

AzimuthPrediction LiveFilter::predictAzimuth(const OdometryWindow& nearby, int light) const {
  if (paper_) {
    const AzimuthModel model = paper_->expectAzimuth();
    const CartesianEstimate cartesian = estimate().cartesian();
    return {model.azimuth_rad, varianceOf(model.J_azimuth_state, paper_->covariance()),
            cartesian.range(), cartesian.rangeVariance()};
  }
  const ExpectedAngle expected = expectAzimuth(state_.layout, state_.mean, light, nearby);
  const CartesianEstimate cartesian = state_.cartesian(light);
  return {expected.angle_rad, varianceOf(expected.J_angle_state, state_.covariance),
          cartesian.range(), cartesian.rangeVariance()};
}

void LiveFilter::update(const Bearing& bearing, const OdometryWindow& nearby, int light) {
  if (paper_) return paper_->update(bearing.azimuth_rad, bearing.azimuth_variance_rad2);
  const ExpectedAngle expected = expectAzimuth(state_.layout, state_.mean, light, nearby);
  apply(prepareUpdate(expected.J_angle_state, wrapAngle(bearing.azimuth_rad - expected.angle_rad),
                      bearing.azimuth_variance_rad2, state_),
        &state_);
  const std::optional<Elevation> elevation = elevationOf(bearing);
  if (elevation && state_.layout.errors > placeOf<SensorTilt>())
    updateByElevation(*elevation, nearby, light);
  state_.wrapYaw();
}

/// An unlikely elevation counts as one of so much larger a variance that it pulls by the limit.
void LiveFilter::updateByElevation(const Elevation& elevation, const OdometryWindow& nearby,
                                   int light) {
  const ExpectedAngle expected = expectElevation(state_.layout, state_.mean, light, nearby);
  const double residual = elevation.angle_rad - expected.angle_rad;
  const double expected_variance = varianceOf(expected.J_angle_state, state_.covariance);
  const double variance = expected_variance + elevation.variance_rad2;
  const double doubt = huber(residual / std::sqrt(variance), kElevationHuberSigmas).doubt;
  apply(
      prepareUpdate(expected.J_angle_state, residual, doubt * variance - expected_variance, state_),
      &state_);
}

StateEstimate LiveFilter::estimate() const {
  return paper_ ? StateEstimate::of(cartesianFromPaper({paper_->mean(), paper_->covariance()}))
                : state_;
}

PaperEstimate LiveFilter::paper() const {
  return paper_ ? paper_->estimate() : paperFromCartesian(state_.cartesian());
}

}  // namespace bearing_calibration::core
