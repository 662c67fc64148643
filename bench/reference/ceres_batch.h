#pragma once

#include <vector>

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/init/closed_form.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/record_track.h"

namespace bearing_calibration::core::reference {

/// What Ceres found. `cost` is counted as the package's own estimators do: twice that of Ceres.
struct CeresAnswer {
  Vector5 state = Vector5::Zero();
  Eigen::Matrix3d mount_covariance = Eigen::Matrix3d::Zero();  ///< where asked for
  double cost = 0.0;
  int iterations = 0;
  bool converged = false;
};

/// How long Ceres goes on: its own default, or until nothing changes any more.
enum class CeresTolerance { kDefault, kTight };

/// Whether Ceres computes the covariance of the mount (x, y, yaw), too.
enum class CeresCovariance { kNone, kMount };

/// The batch estimator reduced to what Ceres is asked for: a cost with Huber's loss (0: none).
BatchConfig costAlone(double huber_sigmas);

/// The batch estimate by Ceres: the same cost as BatchEstimator with nothing left out, as a graph
/// of robot poses with one light and one mount. One thread, automatic derivatives, sparse Cholesky.
/// @param start  as for BatchEstimator; the poses start at the odometry's word
/// @param huber_sigmas  0: plain least squares
/// @returns state at the last observation
CeresAnswer estimateByCeres(const std::vector<Observation>& observations, const RecordStart& start,
                            double huber_sigmas, CeresTolerance tolerance,
                            CeresCovariance covariance = CeresCovariance::kNone);

/// fitOnFixedPath() by Ceres, for a path without errors (its observations' heading and position
/// variances are not used): five unknowns, dense QR. State at the record's first observation.
CeresAnswer fitOnFixedPathByCeres(const std::vector<PosedObservation>& observations,
                                  const Vector5& start, double huber_sigmas,
                                  CeresTolerance tolerance);

/// The usual way to a start from nothing where no closed form is known: that fit from `starts` yaws
/// all around, the light a metre in front of the first bearing; the best one counts.
CeresAnswer findStartByCeres(const std::vector<PosedObservation>& observations, int starts,
                             double huber_sigmas);

}  // namespace bearing_calibration::core::reference
