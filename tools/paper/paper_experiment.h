#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "bearing_calibration/filter/paper_filter.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// How the paper's filter is begun: standard deviations about a guess of X = [D, theta, phi, rho,
/// psi].
struct PaperStart {
  /// phi [rad], rho [m], psi [rad] of the guess; D and theta are taken as they are (the paper says
  /// where its robot starts).
  Eigen::Vector3d mount_guess = Eigen::Vector3d::Zero();
  Vector5 stddev = Vector5::Zero();
};

/// One moment of one run; vectors are (phi [rad], rho [m], psi [rad]).
struct PaperMoment {
  std::size_t observation = 0;  ///< its index in the run
  double time_s = 0.0;
  double distance_m = 0.0;  ///< that the base's centre has driven
  Eigen::Vector3d error;    ///< estimate minus truth, the angles wrapped
  Eigen::Vector3d stddev;   ///< as the filter says
  Eigen::Vector3d bound;    ///< standard deviation that no unbiased estimator with this start beats
  Eigen::Vector3d bound_unknown;  ///< the same when nothing is known at the start
};

/// The paper's EKF (its section III, with the exact arc of model.md, eq. 9) over a whole run,
/// at about 200 moments of it and the last one.
/// @param stated_stddev_rad  of a bearing, as the filter takes it; the bounds take that of the
/// observations
std::vector<PaperMoment> runPaperFilter(const ObservationRun& run, const PaperStart& start,
                                        double stated_stddev_rad);

/// (phi, rho, psi) of a run's true mount.
Eigen::Vector3d trueMount(const ObservationRun& run);

}  // namespace bearing_calibration::core
