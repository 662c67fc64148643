#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/simulation/trajectory.h"

namespace bearing_calibration::core {

/// What may be unknown beside the light and the mount; each block is switched on by itself.
enum class Unknown {
  kWheelScales,      ///< of the left and of the right wheel
  kWheelSeparation,  ///< b
  kTimeOffset,       ///< of the camera's clock
  kFirstHarmonic,    ///< of the azimuth's error: (c1, s1)
  kTilt,             ///< of the whole sensor about its x and y axes
  kLightHeight,      ///< over the sensor
  kSecondLight,      ///< which is seen, too
};

/// In which numbers light, mount and robot are written: the rank of a state is that of its
/// parametrisation.
enum class Parametrisation {
  kCartesian,       ///< light and sensor in the base frame: 5
  kPaper,           ///< X = [D, theta, phi, rho, psi]: 5
  kPaperAugmented,  ///< X_a = [x_R, y_R, theta_R, phi, rho, psi], the light at the origin: 6
};

/// One line of the table of ranks.
struct ObservabilityCase {
  std::string motion;  ///< in words
  std::vector<DriveSegment> segments;
  Parametrisation parametrisation = Parametrisation::kCartesian;
  std::vector<Unknown> unknowns;
  bool with_elevation = false;  ///< the light's elevation is measured, too
  double light_x_m = 2.0;       ///< in the base frame of the start
  double light_y_m = 0.7;
  int expected_rank = 0;  ///< as model.md has it
};

struct ObservabilityRank {
  int unknowns = 0;
  int rank = 0;
  /// Singular values of the Jacobian, its columns scaled to length 1: the last one that counts and
  /// the first one that does not, over the largest.
  double least_counted = 0.0;
  double most_neglected = 0.0;
};

/// Rank of the Fisher information of noise-free odometry: the Jacobian of all bearings by the
/// unknowns, differentiated automatically (exact to rounding), by its singular values.
ObservabilityRank rankOf(const ObservabilityCase& observed);

/// The lines of the table in model.md.
std::vector<ObservabilityCase> observabilityCases();

/// The table in Markdown; the lines whose rank is not the expected one say so.
std::string observabilityTable(const std::vector<ObservabilityCase>& cases);

}  // namespace bearing_calibration::core
