#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bearing_calibration/filter/paper_state.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

/// What is still true when a robot starts anew: the mount, and those errors that are the robot's
/// own for good (its wheels, its mirror, how its sensor is tilted), as they hang together.
struct LastingEstimate {
  static constexpr int kMountSize = 3;
  static constexpr int kSize = kMountSize + kErrorCount;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  Vector mean = Vector::Zero();  ///< mount (x [m], y [m], yaw [rad]), then all errors
  /// No row and column of an error that does not last, or was not looked for.
  Matrix covariance = Matrix::Zero();

  static LastingEstimate of(const MountEstimate& mount);
  static LastingEstimate of(const RobotEstimate& robot);
  MountEstimate mount() const;
  bool isKnown(int place) const { return covariance(place, place) > 0.0; }
};

/// "x [m]" and so on, for each place of a LastingEstimate.
std::vector<std::string> lastingNames();

/// Where mount and errors begin in some state, and how many of the errors it has.
struct LastingPlaces {
  int mount = 0;
  int errors = 0;
  int error_count = 0;
};

/// Adds an earlier calibration to a state that rests on other measurements. What was known of the
/// errors before either of them is a part of both, and is counted once (doc/model.md, eq. 25).
/// @param priors  of both
/// @param mean,covariance  of the state
void addEarlier(const LastingEstimate& earlier, const ErrorPriors& priors,
                const LastingPlaces& places, Eigen::Ref<Eigen::VectorXd> mean,
                Eigen::Ref<Eigen::MatrixXd> covariance);

/// The same for one light with mount and errors.
RobotEstimate withEarlier(const RobotEstimate& estimate, const LastingEstimate& earlier,
                          const ErrorPriors& priors);

}  // namespace bearing_calibration::core
