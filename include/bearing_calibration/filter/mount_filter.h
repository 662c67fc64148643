#pragma once

#include <memory>

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/filter/ekf.h"
#include "bearing_calibration/filter/paper_state.h"

namespace bearing_calibration {

/// An azimuth as the filter expects it, with the variance of that expectation.
struct AzimuthPrediction {
  double azimuth_rad;
  double variance_rad2;

  Innovation innovationOf(double azimuth_rad, double azimuth_variance_rad2) const;
};

/// The filter of a mount and one light, in whatever chart. Predict by the base's motion, update by
/// a bearing; the estimate is the one at the last prediction.
class MountFilter {
 public:
  virtual ~MountFilter() = default;

  virtual void predict(const OdometryIncrement& motion) = 0;
  virtual AzimuthPrediction predictAzimuth() const = 0;
  /// The same after a further motion, leaving the filter as it is.
  virtual AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion) const = 0;
  virtual void update(double azimuth_rad, double azimuth_variance_rad2) = 0;

  virtual CartesianEstimate cartesian() const = 0;
  virtual PaperEstimate paper() const = 0;
  /// Takes up another state of knowledge.
  virtual void restart(const CartesianEstimate& estimate) = 0;
};

/// Light and sensor in the base frame: consistent at any rho (doc/model.md, "Cartesian chart").
std::unique_ptr<MountFilter> makeCartesianFilter(const CartesianEstimate& start);

/// The paper's own filter on X = [D, theta, phi, rho, psi].
std::unique_ptr<MountFilter> makePaperFilter(const CartesianEstimate& start);

}  // namespace bearing_calibration
