#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/solve/mount_displacement.h"

namespace bearing_calibration::core {

/// Whether an observation is the first one of its image: several lights of one image follow each
/// other in a record, each one's number greater than that before it, and the motion is the first
/// one's.
bool beginsImage(const std::vector<Observation>& observations, std::size_t i);

/// How one observation of a record is weighed in a smoother pass.
struct ObservationWeight {
  double sensor_variance_rad2 = 0.0;   ///< of an ordinary bearing
  double bearing_variance_rad2 = 0.0;  ///< what the pass uses: larger for a doubtful bearing
  bool use_bearing = true;
  bool slipped = false;  ///< the motion to this observation's image is not trusted at all
  /// Times the elevation's own variance: of an ordinary one, and that again for a doubtful one. It
  /// is used with the bearing.
  double elevation_widening = 1.0;
  double elevation_doubt = 1.0;
};

/// An observation's place on the path that a pass is linearised about.
struct PathPoint {
  LightPositions lights_in_base;
  /// What the odometry missed (x, y, yaw) on the motion to this observation's image: true minus
  /// measured.
  Eigen::Vector3d motion_error = Eigen::Vector3d::Zero();
};

/// What a pass is linearised about.
struct RecordPath {
  std::vector<PathPoint> points;                    ///< one for each observation
  Eigen::Vector3d mount = Eigen::Vector3d::Zero();  ///< sensor x, y, yaw in the base frame
  ErrorVector errors = ErrorVector::Zero();

  int lights() const { return static_cast<int>(points.front().lights_in_base.cols()); }
  double rangeAt(std::size_t observation, int light) const;  ///< from the sensor to a light [m]
  /// One light with the mount at an observation.
  Vector5 state(std::size_t observation, int light = 0) const;
  /// Mount, errors and all lights at an observation.
  StateVector stateAt(const StateLayout& layout, std::size_t observation) const;
  /// So large a share of the way to another path of the same observations.
  RecordPath towards(const RecordPath& other, double share) const;
};

/// One observation seen from all others of the record.
struct SmoothedObservation {
  Innovation azimuth{0.0, 0.0};         ///< against the observations before it
  std::optional<Innovation> elevation;  ///< against the observations before it and its own azimuth
  /// Against all other observations, and the variance of what those expect, without the bearing's
  /// own.
  double left_out_residual_rad = 0.0;
  double left_out_variance_rad2 = 0.0;
  /// What giving up the motion to this image would take off the cost: chi-square without slip, of 2
  /// degrees with one light, of 3 with several; 0 but for the image's first observation, after a
  /// motion that is not given up.
  double slip_gain = 0.0;
  MountDisplacement mount_displacement;  ///< between the observation before and this one
};

/// A whole record, smoothed once about a given path.
struct SmootherPass {
  std::vector<SmoothedObservation> observations;
  RecordPath path;              ///< smoothed means
  StateEstimate last;           ///< filtered, which is smoothed too, at the last observation
  double motion_cost = 0.0;     ///< squared noise of all motions that the smoothed path implies
  double beginning_cost = 0.0;  ///< the same of what was known at the record's beginning
};

/// Weight of the linearisation point: how far one pass may go from it, as standard deviations of
/// every position [m] and of the yaw [rad]. Large enough, it leaves the estimate alone.
struct SmootherPrior {
  double position_stddev_m;
  double yaw_stddev_rad;
};
inline constexpr SmootherPrior kFreePass{100.0, 100.0};

/// What a slipping wheel may do between two observations (x, y, yaw): wider than any slip, so that
/// nothing of the motion is believed.
Eigen::Matrix3d slipCovariance();

/// What is known before the first bearing; with a beginning, before the first motion.
StateEstimate knownBeforehand(const StateLayout& layout, const RecordPath& path,
                              const SmootherPrior& prior, const ErrorPriors& errors,
                              const StateEstimate* beginning);

/// Kalman filter forward, disturbance smoother (modified Bryson-Frazier) backward; its disturbances
/// are the test statistics for slips and outliers (de Jong and Penzer 1998). Bearings and motions
/// are linearised about `path`, the motions with their errors: to leave those out would reward a
/// light that is too near, where the same turn moves it less (start.md). Elevations count where
/// the sensor's tilt is looked for.
/// @param weights  one for each observation
/// @param prior  without effect where something is known at the record's beginning
/// @param errors  what is known of the robot's errors beforehand; those in use are estimated
/// @param beginning  what is known before the motion to the first observation, which is used then,
///   of the path's lights and the errors in use; null: nothing but `errors`, and no such motion
SmootherPass smooth(const std::vector<Observation>& observations,
                    const std::vector<ObservationWeight>& weights, const RecordPath& path,
                    const SmootherPrior& prior, const ErrorPriors& errors = {},
                    const StateEstimate* beginning = nullptr);

}  // namespace bearing_calibration::core
