#pragma once

#include <limits>
#include <optional>

#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/paper_filter.h"

namespace bearing_calibration::core {

/// An azimuth and a range as the filter expects them, with the variances of that expectation.
struct AzimuthPrediction {
  double azimuth_rad;
  double variance_rad2;
  double range_m = std::numeric_limits<double>::quiet_NaN();  ///< from the sensor to the light
  double range_variance_m2 = std::numeric_limits<double>::quiet_NaN();

  Innovation innovationOf(double azimuth_rad, double azimuth_variance_rad2) const;
};

/// The filter of mount, errors and lights. Predict by the base's motion, update by a bearing; the
/// estimate is the one at the last prediction. It is consistent at any rho (model.md,
/// "Cartesian parametrisation"). A value: a copy goes on by itself.
class LiveFilter {
 public:
  enum class Parametrisation : std::uint8_t {
    kCartesian,  ///< mount, errors and lights in the base frame
    kPaper,      ///< X = [D, theta, phi, rho, psi]: one light, no errors
  };

  explicit LiveFilter(const StateEstimate& start,
                      Parametrisation parametrisation = Parametrisation::kCartesian);

  void predict(const OdometryIncrement& motion);
  /// @param nearby  travel around the stamp of the bearing; without it, as if the base stood
  AzimuthPrediction predictAzimuth(const OdometryWindow& nearby = {}, int light = 0) const;
  /// An elevation is used where the sensor's tilt is among the errors of the state; a wild one
  /// pulls no more than an unlikely one.
  void update(const Bearing& bearing, const OdometryWindow& nearby = {}, int light = 0);

  StateEstimate estimate() const;
  PaperEstimate paper() const;
  /// Takes up another state of knowledge, of the same layout.
  void restart(const StateEstimate& estimate) { *this = LiveFilter(estimate, parametrisation_); }

 private:
  void updateByElevation(const Elevation& elevation, const OdometryWindow& nearby, int light);

  Parametrisation parametrisation_;
  StateEstimate state_;               ///< its layout only, where there is
  std::optional<PaperFilter> paper_;  ///< the paper's
};

}  // namespace bearing_calibration::core
