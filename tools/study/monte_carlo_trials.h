#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/judge/fault.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// The calibration of a simulated robot from nothing, with what its owner states and looks for.
CalibratorConfig calibratorConfig(const SimulatedCase& simulated);
/// An image as that calibration is told of it.
BearingSet toldOf(const SimulatedCase& simulated, const BearingSet& image);

/// Chi-square (3 degrees of freedom) of a mount beyond which an answer is wrong, whatever its own
/// covariance says; by chance it comes about in 1.5 of 100 000 honest ones.
inline constexpr double kWrongChiSquare = 25.0;
/// As improbable, with the light's place.
inline constexpr double kWrongStateChiSquare = 30.0;

/// What an estimator says of one run at one moment, beside the truth and the bound.
struct Snapshot {
  double time_s = 0.0;
  bool has_estimate = false;
  bool claims = false;    ///< ready, or CONVERGED
  bool possible = false;  ///< the Cramer-Rao bound meets the claim's targets with a margin of 1.3
  std::string words;      ///< its state, or why not
  Vector5 error = Vector5::Zero();  ///< of the Cartesian state
  Matrix5 covariance = Matrix5::Zero();
  Matrix5 bound = Matrix5::Zero();
  ErrorVector robot_error = ErrorVector::Zero();  ///< of what is said of the robot's errors
  ErrorVector robot_stddev = ErrorVector::Zero();
  Eigen::Vector2d polar_error = Eigen::Vector2d::Zero();  ///< (phi [rad], rho [m])
  double psi_error_rad = 0.0;
  Eigen::Vector3d polar_bound = Eigen::Vector3d::Zero();  ///< variances of (phi, rho, psi)
  /// Mount (x, y, yaw) less that of a fit of the whole record, where SimulatedCase asks for it and
  /// the fit has settled.
  std::optional<Eigen::Vector3d> off_whole_record;
  double milliseconds = 0.0;  ///< of CPU time

  double mountChiSquare() const;
  double stateChiSquare() const;
  /// An estimate whose mount is beyond kWrongChiSquare.
  bool failed() const { return has_estimate && mountChiSquare() > kWrongChiSquare; }
};

/// Estimate and errors of a snapshot.
/// @param truth  the Cartesian state at the same moment
void fillErrors(const CartesianEstimate& estimate, const Vector5& truth, Snapshot& snapshot);

/// One run: snapshots at the moments asked for, and the worst claim that was made in between.
struct Trial {
  std::vector<Snapshot> snapshots;
  std::optional<double> first_claim_s;
  double worst_claim = 0.0;  ///< largest chi-square(3) of the mount while claimed
  bool is_sound = false;     ///< neither slips nor false or correlated bearings
  std::string alarm;         ///< first time that it was called INCONSISTENT, and why; empty: never
  std::set<Fault> causes;    ///< all that were said of it while it was
};

using TrialFunction = Trial (*)(const SimulatedCase& simulated, const std::vector<double>& times_s);

/// The initialiser on the record so far.
Trial tryInitializer(const SimulatedCase& simulated, const std::vector<double>& times_s);
/// The batch estimator on the record so far, begun at the truth: the reference of all others. It
/// claims whenever it has converged.
Trial tryBatch(const SimulatedCase& simulated, const std::vector<double>& times_s);
/// The whole calibration, fed with ticks and bearings, asked once a second.
Trial tryCalibrator(const SimulatedCase& simulated, const std::vector<double>& times_s);

}  // namespace bearing_calibration::core
