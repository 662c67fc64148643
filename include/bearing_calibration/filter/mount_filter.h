#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/filter/ekf.h"
#include "bearing_calibration/filter/paper_state.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

/// An azimuth as the filter expects it, with the variance of that expectation.
struct AzimuthPrediction {
  double azimuth_rad;
  double variance_rad2;

  Innovation innovationOf(double azimuth_rad, double azimuth_variance_rad2) const;
};

/// The filter of a mount and one light, in whatever parametrisation. Predict by the base's motion,
/// update by a bearing; the estimate is the one at the last prediction.
class MountFilter {
 public:
  virtual ~MountFilter() = default;
  virtual std::unique_ptr<MountFilter> clone() const = 0;

  virtual void predict(const OdometryIncrement& motion) = 0;
  /// @param nearby  travel around the stamp of the bearing; without it, as if the base stood
  virtual AzimuthPrediction predictAzimuth(const OdometryWindow& nearby = {}) const = 0;
  /// The same after a further motion, leaving the filter as it is.
  virtual AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion,
                                                const OdometryWindow& nearby = {}) const = 0;
  /// @param elevation  used where the sensor's tilt is among the errors of the state; a wild one
  ///   pulls no more than an unlikely one
  virtual void update(double azimuth_rad, double azimuth_variance_rad2,
                      const OdometryWindow& nearby = {},
                      const std::optional<Elevation>& elevation = std::nullopt) = 0;

  virtual CartesianEstimate cartesian() const = 0;
  virtual PaperEstimate paper() const = 0;
  virtual RobotEstimate robot() const = 0;
  /// Takes up another state of knowledge.
  virtual void restart(const RobotEstimate& estimate) = 0;
};

/// The filter on light and sensor in the base frame, consistent at any rho (doc/model.md,
/// "Cartesian parametrisation"), with the first `errors_in_use` of the robot's errors (see
/// errorsInUse()).
std::unique_ptr<MountFilter> makeCartesianFilter(const RobotEstimate& start, int errors_in_use = 0);

/// A filter as a value: a copy is a filter of its own in the same state.
class FilterValue {
 public:
  explicit FilterValue(std::unique_ptr<MountFilter> filter) : filter_(std::move(filter)) {}
  FilterValue(const FilterValue& other) : filter_(other.filter_->clone()) {}
  FilterValue(FilterValue&&) noexcept = default;
  FilterValue& operator=(FilterValue other) noexcept {
    filter_ = std::move(other.filter_);
    return *this;
  }
  ~FilterValue() = default;

  MountFilter* get() { return filter_.get(); }
  MountFilter* operator->() { return filter_.get(); }
  const MountFilter* operator->() const { return filter_.get(); }
  const MountFilter& operator*() const { return *filter_; }

 private:
  std::unique_ptr<MountFilter> filter_;
};

}  // namespace bearing_calibration::core
