#pragma once

#include <memory>

#include "bearing_calibration/filter/mount_filter.h"

namespace bearing_calibration::core {

/// The paper's own filter on X = [D, theta, phi, rho, psi] (its section III), with the exact arc of
/// doc/model.md, eq. 9. It may begin at rho = 0.
class PaperEkf {
 public:
  explicit PaperEkf(const Gaussian<5>& state) : state_(state) {}

  void predict(const OdometryIncrement& motion);
  AzimuthPrediction predictAzimuth() const;
  void update(double azimuth_rad, double azimuth_variance_rad2);
  /// Goes on from another mean with the covariance as it is.
  void setMean(const Vector5& mean) { state_.mean = mean; }

  const Gaussian<5>& state() const { return state_; }

 private:
  Gaussian<5> state_;
};

/// The same as a filter of the calibration. It knows no errors of the robot: robot() says that
/// there are none.
std::unique_ptr<MountFilter> makePaperFilter(const CartesianEstimate& start);

}  // namespace bearing_calibration::core
