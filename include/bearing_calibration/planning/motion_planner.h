#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/optics/field_of_view.h"
#include "bearing_calibration/planning/motion_primitive.h"

namespace bearing_calibration::core {

/// What a robot's sensors will tell on its way, as the filter models it.
struct SensingModel {
  WheelNoise wheel_noise;
  double bearing_stddev_rad = 0.0;  ///< of one bearing
  double bearing_rate_hz = 0.0;
  FieldOfView view = {};           ///< no parameter: the sensor says it
  double nearness_stddev_m = 0.0;  ///< the same: what no bearing will tell (ErrorPriors)

  void declare(Parameters& params);
};

/// Parameter group `planner`.
struct PlannerConfig {
  /// What is to become well known: the determinant of this block's covariance is made small.
  enum class Block : std::uint8_t {
    kMount,     ///< x, y and yaw of the sensor
    kPosition,  ///< x and y alone
    kYaw,
  };
  Block block = Block::kMount;
  double light_distance_m = 0.0;  ///< of the base's centre to the light, at least ...
  double light_sigmas = 0.0;      ///< ... with so many standard deviations to spare
  double region_margin_m = 0.0;   ///< planned ways keep this distance from the region's border
  double max_straight_m = 0.0;    ///< longest straight way between two decisions

  void declare(Parameters& params);
};

/// The estimate as the filter will have it after a primitive: the mean moves as planned, the
/// covariance grows by the wheels' noise and shrinks by the bearings (model.md, eqs. 5 to 8, 16
/// to 18). Bearings are taken together over steps of at most a quarter of a second, and count as
/// far as it is probable that the light is in view. Errors of the wheels belong to the estimate: an
/// unequal wheel bends a straight way as a light's parallax would, so that who does not doubt the
/// wheels expects of such ways what they cannot teach.
StateEstimate predictAfter(const MotionPrimitive& primitive, StateEstimate estimate,
                           const WheelLimits& limits, const SensingModel& sensing);

/// Probability that the light is in view.
/// @param nearby  travel around that moment; without it, as if the base stood
double chanceInView(const FieldOfView& view, const StateEstimate& estimate,
                    const OdometryWindow& nearby = {});

/// How near a primitive comes to the light at most, by what is known before it: the least distance
/// from the base's centre to the light minus `sigmas` standard deviations in that direction [m].
double lightClearance(const MotionPrimitive& primitive, const StateEstimate& estimate,
                      double sigmas, int light = 0);

/// The estimate with a further light, which is kept away from.
StateEstimate withLight(const StateEstimate& estimate, const Eigen::Vector2d& light_m,
                        const Eigen::Matrix2d& covariance);

/// A primitive with what it is expected to bring.
struct PlannedPrimitive {
  MotionPrimitive primitive;
  MotionPrimitive next;    ///< the one that is thought of after it; decided anew by then
  MountEstimate expected;  ///< after both
};

/// Everything that a robot must know of itself to plan. What primitives are allowed, and which is
/// best.
class MotionPlanner {
 public:
  /// @throws std::invalid_argument with every sentence of the parts' errorsOf().
  MotionPlanner(const PlannerConfig& config, const WheelLimits& limits, const SensingModel& sensing,
                const Region& region);

  /// What the sensor says of itself, from the next plan on.
  void setView(const FieldOfView& view) { sensing_.view = view; }
  void setNearness(double stddev_m) { sensing_.nearness_stddev_m = stddev_m; }

  /// The next primitive: the first of the pair of primitives that lowers the log det of the block's
  /// covariance fastest. None when no way is allowed.
  /// @param estimate  withoutNearness()
  std::optional<PlannedPrimitive> plan(const StateEstimate& estimate,
                                       const Pose2& start_from_base) const;

  /// Whether a primitive keeps away from each light, or at least comes no nearer than the robot is:
  /// even if the light stands as much nearer as may well be, or, of a way that somebody has asked
  /// for, only if it stands as much farther.
  bool keepsAway(const MotionPrimitive& primitive, const StateEstimate& estimate,
                 bool is_asked_for = false) const;
  /// Whether a primitive keeps inside the region, or at least comes no nearer to its border.
  bool staysInside(const MotionPrimitive& primitive, const Pose2& start_from_base) const;

 private:
  struct Candidate;
  std::vector<MotionPrimitive> proposals(const StateEstimate& estimate) const;
  std::vector<Candidate> candidatesAt(const StateEstimate& estimate,
                                      const Pose2& start_from_base) const;
  StateEstimate after(const MotionPrimitive& primitive, const StateEstimate& estimate) const {
    return predictAfter(primitive, estimate, limits_, sensing_);
  }
  MountEstimate mountOf(const StateEstimate& estimate) const {
    return withNearness(estimate, sensing_.nearness_stddev_m).mount();
  }
  double logDet(const StateEstimate& estimate) const;

  PlannerConfig config_;
  WheelLimits limits_;
  SensingModel sensing_;
  Region region_;
};

}  // namespace bearing_calibration::core
