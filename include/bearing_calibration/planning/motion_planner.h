#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/planning/primitive_prediction.h"
#include "bearing_calibration/planning/region.h"

namespace bearing_calibration::core {

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

/// A primitive with what it is expected to bring.
struct PlannedPrimitive {
  MotionPrimitive primitive;
  MotionPrimitive next;    ///< the one that is thought of after it; decided anew by then
  RobotEstimate expected;  ///< after both
};

/// Everything that a robot must know of itself to plan. What primitives are allowed, and which is
/// best.
class MotionPlanner {
 public:
  /// @throws std::invalid_argument with every sentence of the parts' errorsOf().
  MotionPlanner(const PlannerConfig& config, const WheelLimits& limits, const SensingModel& sensing,
                const Region& region);

  /// The next primitive: the first of the pair of primitives that lowers the log det of the block's
  /// covariance fastest. None when no way is allowed.
  std::optional<PlannedPrimitive> plan(const RobotEstimate& estimate,
                                       const Pose2& start_from_base) const;

  /// Whether a primitive keeps away from the light, or at least comes no nearer than the robot is.
  bool keepsAway(const MotionPrimitive& primitive, const CartesianEstimate& estimate) const;
  /// Whether it comes too near even if the light stands as much farther as may well be: what
  /// forbids a way that somebody has asked for.
  bool isSurelyTooNear(const MotionPrimitive& primitive, const CartesianEstimate& estimate) const;
  /// Whether a primitive keeps inside the region, or at least comes no nearer to its border.
  bool staysInside(const MotionPrimitive& primitive, const Pose2& start_from_base) const;

  const WheelLimits& limits() const { return limits_; }

 private:
  struct Candidate;
  std::vector<MotionPrimitive> proposals(const CartesianEstimate& estimate) const;
  std::vector<Candidate> candidatesAt(const RobotEstimate& estimate,
                                      const Pose2& start_from_base) const;
  double logDet(const CartesianEstimate& estimate) const;

  PlannerConfig config_;
  WheelLimits limits_;
  SensingModel sensing_;
  Region region_;
};

/// The base's pose after a primitive, in the frame that `frame_from_base` is given in.
Pose2 poseAfter(const MotionPrimitive& primitive, const Pose2& frame_from_base);

}  // namespace bearing_calibration::core
