#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/filter/ekf.h"
#include "bearing_calibration/filter/error_blocks.h"

namespace bearing_calibration::core {

namespace detail {
template <class... Blocks>
constexpr int sizeOf(std::tuple<Blocks...>*) {
  return (0 + ... + Blocks::kSize);
}
}  // namespace detail

/// Place of a block's first number among all of them.
template <class Block, std::size_t I = 0>
constexpr int placeOf() {
  using Candidate = std::tuple_element_t<I, ErrorBlocks>;
  if constexpr (std::is_same_v<Block, Candidate>) {
    return 0;
  } else {
    return Candidate::kSize + placeOf<Block, I + 1>();
  }
}

/// All numbers of all blocks.
inline constexpr int kErrorCount = detail::sizeOf(static_cast<ErrorBlocks*>(nullptr));
using ErrorVector = Eigen::Matrix<double, kErrorCount, 1>;
using ErrorMatrix = Eigen::Matrix<double, kErrorCount, kErrorCount>;

/// What is known of the robot's errors beforehand.
struct ErrorPriors {
  ErrorVector stddev = ErrorVector::Zero();  ///< zero: that error is known to be the mean
  ErrorVector mean = ErrorVector::Zero();    ///< zero but for what is looked for about it
  double light_height_m = 0.0;               ///< as stated, looked for or not
  double light_height_stddev_m = 0.0;        ///< the same
  /// How far a misaligned mirror may shift the sensor, to every side: no bearing tells it, so that
  /// it is no error in the state, but a part of what is said of the mount (withNearness()).
  double nearness_stddev_m = 0.0;

  /// Sets the standard deviation of a whole block, times its weights for each of its numbers.
  /// @throws std::invalid_argument when no block is called so
  void setBlock(const std::string& name, double stddev);

  /// What is known of the light's height over the sensor [m]: without effect where no tilt of the
  /// sensor is looked for.
  void setLightHeight(double mean_m, double stddev_m);

  /// Looks for the misaligned mirror that a sensor's geometry leaves room for.
  void setGeometry(const SensorGeometry& geometry);
  /// What of it is looked for.
  SensorGeometry geometry() const;

  /// Whether elevations of the light tell anything that is looked for.
  bool usesElevations() const {
    return (stddev.segment<SensorTilt::kSize>(placeOf<SensorTilt>()).array() > 0.0).any();
  }

  void declare(Parameters& params);
};

/// The mount with what the sensor's nearness leaves open of it.
CartesianEstimate withNearness(CartesianEstimate estimate, double nearness_stddev_m);

/// What is known of the robot's errors now.
struct ErrorEstimate {
  ErrorVector mean = ErrorVector::Zero();
  ErrorMatrix covariance = ErrorMatrix::Zero();
  /// Of the Cartesian state's entries with them.
  Eigen::Matrix<double, 5, kErrorCount> cross_covariance =
      Eigen::Matrix<double, 5, kErrorCount>::Zero();
};

/// Before anything is measured.
ErrorEstimate priorEstimate(const ErrorPriors& priors);

/// Mount, light and the robot's errors.
struct RobotEstimate {
  CartesianEstimate cartesian;
  ErrorEstimate errors;

  /// Mean and covariance of the state and the first K errors in one piece.
  template <int K>
  Gaussian<5 + K> joint() const {
    Gaussian<5 + K> joint;
    joint.mean << cartesian.mean, errors.mean.head<K>();
    joint.covariance << cartesian.covariance, errors.cross_covariance.leftCols<K>(),
        errors.cross_covariance.leftCols<K>().transpose(), errors.covariance.topLeftCorner<K, K>();
    return joint;
  }
  /// The same back again; the other errors are zero.
  template <int K>
  static RobotEstimate from(const Gaussian<5 + K>& joint) {
    RobotEstimate robot;
    robot.cartesian = {joint.mean.template head<5>(),
                       joint.covariance.template topLeftCorner<5, 5>()};
    robot.errors.mean.head<K>() = joint.mean.template tail<K>();
    robot.errors.covariance.topLeftCorner<K, K>() =
        joint.covariance.template bottomRightCorner<K, K>();
    robot.errors.cross_covariance.leftCols<K>() = joint.covariance.template topRightCorner<5, K>();
    return robot;
  }
};

/// A motion with the errors put right, and its Jacobian by the first K of them.
template <int K>
CorrectedMotion<K> correctMotion(const OdometryIncrement& measured, const ErrorVector& errors);

/// P <- T P T' + noise for the state [light, mount, K errors], where a motion turns the light by R,
/// moves it with the errors by J and shakes it; nothing else moves. T is never multiplied out: two
/// rows and two columns change.
template <int K>
void propagateCovariance(const Eigen::Matrix2d& R_end_start,
                         const Eigen::Matrix<double, 2, K>& J_light_errors,
                         const Eigen::Matrix2d& light_noise,
                         Eigen::Matrix<double, 5 + K, 5 + K>& covariance) {
  Eigen::Matrix<double, 2, 5 + K> rows = R_end_start * covariance.template topRows<2>();
  if constexpr (K > 0) rows += J_light_errors * covariance.template bottomRows<K>();
  covariance.template topRows<2>() = rows;
  Eigen::Matrix<double, 5 + K, 2> columns =
      covariance.template leftCols<2>() * R_end_start.transpose();
  if constexpr (K > 0) {
    columns += covariance.template rightCols<K>() * J_light_errors.transpose();
  }
  covariance.template leftCols<2>() = columns;
  covariance.template topLeftCorner<2, 2>() += light_noise;
}

/// The azimuth [rad] at which the sensor sees the light, errors and all, with its Jacobian by the
/// Cartesian state at the stamp and the first K errors (doc/model.md, eqs. 6, 16, 19, 20).
template <int K>
struct ObservationModel {
  double azimuth_rad;
  Eigen::Matrix<double, 1, 5 + K> J_azimuth_state;
};
template <int K>
ObservationModel<K> expectObservation(const Vector5& state, const ErrorVector& errors,
                                      const OdometryWindow& nearby);

/// The elevation [rad] at which the sensor sees the light, as above (doc/model.md, eq. 20): only
/// with all errors in the state.
struct ElevationModel {
  double elevation_rad;
  Eigen::Matrix<double, 1, 5 + kErrorCount> J_elevation_state;
};
ElevationModel expectElevation(const Vector5& state, const ErrorVector& errors,
                               const OdometryWindow& nearby);

/// How many of the errors, from the first on, a filter must carry so that all with a prior are
/// among them: one of the sizes that the templates above are made for.
int errorsInUse(const ErrorPriors& priors);

/// Whether an error is the same when the robot starts anew.
bool lasts(int error);

/// Each of the errors.
const std::vector<Quantity>& errorQuantities();
/// "time_offset [s]"; a ratio has no unit.
std::string labelOf(const Quantity& quantity);

/// A block by its name and its place among the errors.
struct ErrorBlockInfo {
  std::string name;
  int begin = 0;
  int size = 0;
  std::string when_held;  ///< what it means for the result when the data do not tell it
};
const std::vector<ErrorBlockInfo>& errorBlocks();

/// The sizes that filters come in, beside none and all.
inline constexpr int kWheelErrors = placeOf<MirrorHarmonic>();
inline constexpr int kAllButTilt = placeOf<SensorTilt>();

/// Calls `work` with std::integral_constant<int, K> for K = errorsInUse().
template <class Work>
auto withErrorsInUse(int errors_in_use, Work work) {
  if (errors_in_use == 0) return work(std::integral_constant<int, 0>());
  if (errors_in_use <= kWheelErrors) return work(std::integral_constant<int, kWheelErrors>());
  if (errors_in_use <= kAllButTilt) return work(std::integral_constant<int, kAllButTilt>());
  return work(std::integral_constant<int, kErrorCount>());
}

/// Residual of an observation [rad]: measured minus expected.
double residualOf(const Observation& observation, const Vector5& state, const ErrorVector& errors);

/// The same of its elevation; none where it has none.
std::optional<double> elevationResidualOf(const Observation& observation, const Vector5& state,
                                          const ErrorVector& errors);

/// The pose of the base at the moment when an observation was really made, in the base frame at its
/// stamp.
Pose2 stampFromMoment(const Observation& observation, const ErrorVector& errors);

/// The record of a robot without errors that sees the same: motions put right, bearings at their
/// own moments. (What bends a bearing, mirror and tilt, is left in.)
std::vector<Observation> withoutErrors(const std::vector<Observation>& observations,
                                       const ErrorVector& errors);

}  // namespace bearing_calibration::core
