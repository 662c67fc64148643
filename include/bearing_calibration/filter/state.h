#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bearing_calibration/filter/error_blocks.h"

namespace bearing_calibration::core {

/// Where wider instructions may be used (-march=native) Eigen aligns its matrices to more bytes,
/// and whatever contains them lies otherwise in memory. A program that is compiled so, while the
/// core is not, does not find this symbol when it is linked, instead of crashing.
template <int kBytes>
struct EigenAlignedTo {
  static const char kAsInTheCore;
};
template <>
const char EigenAlignedTo<EIGEN_MAX_STATIC_ALIGN_BYTES>::kAsInTheCore;
[[gnu::used]] static const char* const kEigenAlignment =
    &EigenAlignedTo<EIGEN_MAX_STATIC_ALIGN_BYTES>::kAsInTheCore;

inline constexpr int kMountSize = 3;
inline constexpr int kMostState = kMountSize + kErrorCount + 2 * kMostLights;
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostState, 1>;
using StateRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostState>;
using StateMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostState, kMostState>;
/// Lights in the base frame: a column for each.
using LightPositions = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMostLights>;

/// Places of the quantities in the state: sensor x, y, yaw; the first `errors` of the robot's
/// errors; x, y of each light. All in the base frame of now (model.md, "Several lights").
struct StateLayout {
  int errors = 0;
  int lights = 0;

  int lastingSize() const { return kMountSize + errors; }  ///< what is no light
  int lightAt(int light) const { return lastingSize() + 2 * light; }
  int size() const { return lightAt(lights); }
};

/// One light with the mount: [light x, light y, sensor x, sensor y, sensor yaw] in the base frame
/// (model.md, "Cartesian parametrisation").
using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;
struct CartesianIndex {
  enum : int { kLightX = 0, kLightY = 1, kSensorX = 2, kSensorY = 3, kSensorYaw = 4 };
};

/// Mean [m, m, m, m, rad] and covariance of that.
struct CartesianEstimate {
  Vector5 mean = Vector5::Zero();
  Matrix5 covariance = Matrix5::Zero();

  Eigen::Vector2d lightInBase() const { return mean.head<2>(); }
  Eigen::Vector2d sensorInBase() const { return mean.segment<2>(CartesianIndex::kSensorX); }
  double sensorYaw() const { return mean(CartesianIndex::kSensorYaw); }
  double range() const { return (lightInBase() - sensorInBase()).norm(); }
  double rangeVariance() const;
};

/// The sensor's pose in the base frame. mean = (x [m], y [m], yaw [rad]).
struct MountEstimate {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// To the bit: whether there is news, of a fit for instance.
  friend bool operator==(const MountEstimate& a, const MountEstimate& b) {
    return a.mean == b.mean && a.covariance == b.covariance;
  }
};

/// What is known of the robot's errors; zero where they are not looked for.
struct ErrorEstimate {
  ErrorVector mean = ErrorVector::Zero();
  ErrorMatrix covariance = ErrorMatrix::Zero();
};

/// One light with the mount out of a state, and the errors.
Vector5 cartesianOf(const StateLayout& layout, const StateVector& state, int light);
ErrorVector robotErrorsOf(const StateLayout& layout, const StateVector& state);

/// Mean and covariance of mount, errors and any number of lights: the one state of everything that
/// estimates.
struct StateEstimate {
  StateLayout layout;
  StateVector mean;
  StateMatrix covariance;

  /// Zero, of this layout.
  static StateEstimate zero(const StateLayout& layout);
  /// One light and the mount, with errors that are independent of them.
  static StateEstimate of(const CartesianEstimate& cartesian, int errors = 0,
                          const ErrorEstimate& robot = {});

  bool empty() const { return mean.size() == 0; }
  MountEstimate mount() const;
  CartesianEstimate cartesian(int light = 0) const;
  ErrorEstimate errors() const;
  /// Takes another light and mount; nothing is known any longer of how they hang together with the
  /// errors.
  void setCartesian(const CartesianEstimate& cartesian, int light = 0);
  /// The yaw in [-pi, pi].
  void wrapYaw();
};

/// What an estimate says of mount, the first so many errors, and these lights of it. Errors that it
/// does not have are zero; where a place names none of its lights, there is one of which nothing is
/// known.
StateEstimate partOf(const StateEstimate& estimate, int errors,
                     const std::vector<std::optional<int>>& lights);

/// The same with the covariance of mount and lights so many times larger. The robot's errors keep
/// theirs, which an earlier calibration may be subtracted from, and all correlations.
StateEstimate widened(StateEstimate estimate, double widening);

/// An estimate moved as `to` lies against `from`, and with the covariance that `to` has beyond that
/// of `from`.
StateEstimate changedAs(StateEstimate estimate, const StateEstimate& from, const StateEstimate& to);

/// a minus b (x, y, yaw), the yaw wrapped.
Eigen::Vector3d mountDifference(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace bearing_calibration::core
