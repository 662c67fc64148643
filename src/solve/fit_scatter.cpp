#include "bearing_calibration/solve/fit_scatter.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {

Scatter scatterOf(const BatchEstimate& fit) {
  Scatter scatter = fit.beginning ? fit.beginning->scatter : Scatter();
  scatter += scatterOf(fit, 0, fit.mount_displacements.size());
  return scatter;
}

Scatter scatterOf(const BatchEstimate& fit, std::size_t begin, std::size_t end) {
  Scatter scatter;
  for (std::size_t i = begin; i < end; ++i) {
    const DisplacementTest test = testDisplacement(fit.mount_displacements[i]);
    if (test.directions < kMountSize) continue;
    scatter.gain_sum += test.gain;
    scatter.largest_gain = std::max(scatter.largest_gain, test.gain);
    ++scatter.observations;
  }
  return scatter;
}

RobotEstimate widened(RobotEstimate estimate, double widening) {
  estimate.cartesian.covariance *= widening;
  estimate.errors.cross_covariance *= std::sqrt(widening);
  return estimate;
}

LightsEstimate widened(LightsEstimate estimate, double widening) {
  LightsVector scale = LightsVector::Constant(estimate.layout.size(), std::sqrt(widening));
  scale.segment(kMountSize, estimate.layout.errors).setOnes();
  estimate.covariance = scale.asDiagonal() * estimate.covariance * scale.asDiagonal();
  return estimate;
}

}  // namespace bearing_calibration::core
