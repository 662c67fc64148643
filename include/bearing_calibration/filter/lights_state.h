#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/filter/paper_state.h"
#include "bearing_calibration/filter/robot_errors.h"

// One mount and several lights: what MountFilter and the smoother do for one light, for a number of
// them that is known at run time only. Nothing here allocates (doc/model.md, "Several lights").

namespace bearing_calibration::core {

inline constexpr int kMostLights = 8;
inline constexpr int kMountSize = 3;
inline constexpr int kMostLightsState = kMountSize + kErrorCount + 2 * kMostLights;
using LightsVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostLightsState, 1>;
using LightsRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostLightsState>;
using LightsMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostLightsState, kMostLightsState>;
/// The lights' own rows of a covariance.
using LightsRows =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMostLights, kMostLightsState>;
/// The lights themselves, in the base frame: a column for each.
using LightPositions = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMostLights>;

/// Places of the quantities in the state: sensor x, y, yaw; the first `errors` of the robot's
/// errors; x, y of each light. All in the base frame of now.
struct LightsLayout {
  int errors = 0;
  int lights = 0;

  int lightsAt() const { return kMountSize + errors; }
  int lightAt(int light) const { return lightsAt() + 2 * light; }
  int size() const { return lightAt(lights); }
};

/// The Cartesian state of one light with the mount, and the robot's errors, out of a state.
Vector5 stateOf(const LightsLayout& layout, const LightsVector& state, int light);
ErrorVector errorsOf(const LightsLayout& layout, const LightsVector& state);

/// Mean and covariance of mount, errors and all lights.
struct LightsEstimate {
  LightsLayout layout;
  LightsVector mean;
  LightsMatrix covariance;

  MountEstimate mount() const;
  /// One light with mount and errors.
  RobotEstimate robot(int light) const;
};

/// What an estimate says of mount, errors and these lights of it. Where a place names none of its
/// lights, there is one of which nothing is known.
LightsEstimate withLights(const LightsEstimate& estimate,
                          const std::vector<std::optional<int>>& lights);

/// Adds an earlier calibration to an estimate (see LastingEstimate).
void addEarlier(const LastingEstimate& earlier, const ErrorPriors& priors,
                LightsEstimate* estimate);

/// A motion of the base, linearised about its own error and those of the robot, as it moves all
/// lights: l+ = R (l - t) - J error + J_errors (errors - errors*).
struct LightsMotion {
  Pose2 start_from_end;  ///< the measured one with both kinds of error put right
  Eigen::Matrix2d R_end_start;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();       ///< true minus measured (x, y, yaw)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of that error
  LightsVector errors_at;                                ///< the robot's, where it is linearised
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 2 * kMostLights, 3> J_lights_error;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMostLights, kErrorCount>
      J_lights_errors;
};

/// @param lights_at_end  where the lights are after the motion, in the base frame
/// @param error  of the motion, where it is linearised
LightsMotion lineariseMotion(const LightsLayout& layout, const ErrorVector& errors,
                             const LightPositions& lights_at_end, const OdometryIncrement& measured,
                             const Eigen::Vector3d& error);
/// The same about a state before the motion, which has no error of its own.
LightsMotion lineariseMotion(const LightsLayout& layout, const LightsVector& before,
                             const OdometryIncrement& measured);

/// Rounding makes the two halves of a covariance differ a little, and updates make the difference
/// grow: both become their mean.
void symmetrise(LightsMatrix* covariance);

/// Moves an estimate.
void propagate(const LightsMotion& motion, LightsEstimate* estimate);

/// An angle [rad] at which the sensor sees a light, with its Jacobian by the state.
struct LightsAngle {
  double angle_rad;
  LightsRow J_angle_state;
};
LightsAngle expectAzimuth(const LightsLayout& layout, const LightsVector& state, int light,
                          const OdometryWindow& nearby);
/// Only with all errors in the state.
LightsAngle expectElevation(const LightsLayout& layout, const LightsVector& state, int light,
                            const OdometryWindow& nearby);

/// An update by one bearing: what a smoother needs of it on its way back.
struct LightsUpdate {
  LightsRow H;
  LightsVector gain;
  double innovation = 0.0;
  double innovation_variance = 0.0;

  double nis() const { return innovation * innovation / innovation_variance; }
};
/// @param about  the state that the bearing is linearised about
LightsUpdate updateByAzimuth(const LightsVector& about, int light, double azimuth_rad,
                             double azimuth_variance_rad2, const OdometryWindow& nearby,
                             LightsEstimate* estimate);

}  // namespace bearing_calibration::core
