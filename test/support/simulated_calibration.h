#pragma once

#include <limits>
#include <vector>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/simulation/robot_simulator.h"

namespace bearing_calibration::core::testing {

/// The paper's robot (section V-A): K = 1e-6 m, encoders at 100 Hz, bearings of 1 degree at 10 Hz,
/// rho = 0.1 m, phi = psi = 30 degrees, start at (2, 0, 90 degrees) with the light at the origin.
RobotConfig paperRobot(std::uint64_t seed);

/// The calibrator's configuration for that robot, with a start from nothing.
CalibratorConfig calibratorConfig();

/// The paper's second trajectory with the light at the origin.
SimulatedRecord simulate(const RobotConfig& robot, double duration_s);

/// Feeds a record to a calibrator as it would arrive: ticks at their stamps, bearing i after its
/// own by arrival_delays_s[i modulo their number]; only what is stamped in [from_s, to_s) after the
/// start.
CalibrationResult play(const SimulatedRecord& record, Calibrator* calibrator,
                       const std::vector<double>& arrival_delays_s = {0.0}, double from_s = 0.0,
                       double to_s = std::numeric_limits<double>::infinity());

/// Squared Mahalanobis distance of the estimate from the truth, 3 degrees of freedom.
double mountChiSquare(const MountEstimate& estimate, const Pose2& truth);

}  // namespace bearing_calibration::core::testing
