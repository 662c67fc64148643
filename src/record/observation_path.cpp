#include "bearing_calibration/record/observation_path.h"

#include <cmath>
#include <cstddef>

#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/record/observation_record.h"

namespace bearing_calibration::core {
namespace {

/// What each wheel rolled in a motion (left [m], right [m]), whatever way it took: a motion that
/// was put together from several may turn by more than half a turn, which its yaw alone does not
/// show.
Eigen::Vector2d wheelsOf(const OdometryIncrement& motion, double wheel_separation_m) {
  return wheel_separation_m *
         Eigen::Vector2d(-motion.J_pose_wheels(2, 0), motion.J_pose_wheels(2, 1));
}

/// The one arc on which the wheels roll so far, without noise.
OdometryIncrement arcOf(const Eigen::Vector2d& wheels_m, double wheel_separation_m) {
  return append(OdometryIncrement(), {wheels_m.x(), wheels_m.y()}, wheel_separation_m,
                WheelNoise());
}

/// What a motion is beyond one arc: zero for a single one.
Eigen::Vector2d beyondArc(const OdometryIncrement& motion, const OdometryIncrement& arc) {
  return motion.start_from_end.position_m - arc.start_from_end.position_m;
}

/// Whether no wheel is another one, and each rolls so little farther or less far than it says, for
/// their separation, that it changes a motion to first order.
bool isSmall(const Eigen::Matrix2d& wheels_from_wheels, double separation_factor) {
  constexpr double kMost = 0.4;
  return wheels_from_wheels.isDiagonal() && std::abs(separation_factor - 1.0) < kMost &&
         ((wheels_from_wheels.diagonal().array() - 1.0).abs() < kMost).all();
}

/// The first part of a motion, as far as it is one arc; the rest is spread evenly.
Pose2 partOf(const OdometryIncrement& motion, double fraction, double wheel_separation_m) {
  const Eigen::Vector2d wheels = wheelsOf(motion, wheel_separation_m);
  Pose2 part = arcOf(fraction * wheels, wheel_separation_m).start_from_end;
  part.position_m += fraction * beyondArc(motion, arcOf(wheels, wheel_separation_m));
  return part;
}

}  // namespace

std::vector<PosedObservation> poseObservations(const std::vector<Observation>& observations) {
  std::vector<PosedObservation> posed;
  posed.reserve(observations.size());
  PosedObservation now;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (i > 0) {
      const OdometryIncrement& motion = observations[i].motion;
      now.first_from_base = now.first_from_base * motion.start_from_end;
      now.heading_variance_rad2 += motion.covariance(2, 2);
      now.position_variance_m2 += 0.5 * motion.covariance.topLeftCorner<2, 2>().trace();
    }
    now.azimuth_rad = observations[i].azimuth_rad;
    now.azimuth_variance_rad2 = observations[i].azimuth_variance_rad2;
    posed.push_back(now);
  }
  return posed;
}

std::vector<Observation> thinned(const std::vector<Observation>& observations,
                                 std::size_t max_observations) {
  if (observations.size() <= max_observations) return observations;
  ObservationRecordConfig config;
  config.capacity = max_observations;
  ObservationRecord record(config);
  for (const Observation& observation : observations) record.add(observation);
  return record.observations();
}

std::vector<Observation> withOtherWheels(const std::vector<Observation>& observations,
                                         const Eigen::Matrix2d& wheels_from_wheels,
                                         double nominal_separation_m, double changed_separation_m) {
  std::vector<Observation> changed = observations;
  for (Observation& observation : changed) {
    OdometryIncrement& motion = observation.motion;
    const Eigen::Vector2d wheels = wheelsOf(motion, nominal_separation_m);
    const OdometryIncrement believed = arcOf(wheels, nominal_separation_m);
    OdometryIncrement arc = arcOf(wheels_from_wheels * wheels, changed_separation_m);
    if (isSmall(wheels_from_wheels, changed_separation_m / nominal_separation_m)) {
      const Eigen::Vector3d scale_errors(wheels_from_wheels(0, 0) - 1.0,
                                         wheels_from_wheels(1, 1) - 1.0,
                                         changed_separation_m / nominal_separation_m - 1.0);
      const Eigen::Matrix<double, 2, 3> J_beyond =
          (motion.J_pose_wheels - believed.J_pose_wheels).topRows<2>();
      arc.start_from_end.position_m += beyondArc(motion, believed) + J_beyond * scale_errors;
      arc.J_pose_wheels.topRows<2>() += J_beyond;
      arc.distance_m += motion.distance_m - believed.distance_m;
      arc.rotation_rad += motion.rotation_rad - believed.rotation_rad;
    }
    arc.covariance = motion.covariance;
    arc.has_unseen = motion.has_unseen;
    motion = arc;
    observation.nearby =
        observation.nearby.withOtherWheels(wheels_from_wheels, changed_separation_m);
  }
  return changed;
}

std::vector<Observation> mirrored(const std::vector<Observation>& observations) {
  const Eigen::Vector3d flip(1.0, -1.0, -1.0);  // x, y, yaw
  const Eigen::Matrix2d swapped = (Eigen::Matrix2d() << 0.0, 1.0, 1.0, 0.0).finished();
  std::vector<Observation> changed = observations;
  for (Observation& observation : changed) {
    OdometryIncrement& motion = observation.motion;
    motion.start_from_end.position_m.y() *= -1.0;
    motion.start_from_end.yaw_rad *= -1.0;
    motion.covariance = flip.asDiagonal() * motion.covariance * flip.asDiagonal();
    motion.J_pose_wheels = flip.asDiagonal() * motion.J_pose_wheels;
    motion.J_pose_wheels.col(0).swap(motion.J_pose_wheels.col(1));
    observation.nearby =
        observation.nearby.withOtherWheels(swapped, observation.nearby.wheelSeparation());
  }
  return changed;
}

std::vector<Observation> withEarlierBearings(const std::vector<Observation>& observations,
                                             double earlier_s, double wheel_separation_m) {
  std::vector<Pose2> first_from_base(1);
  for (std::size_t i = 1; i < observations.size(); ++i) {
    first_from_base.push_back(first_from_base.back() * observations[i].motion.start_from_end);
  }
  const Duration earlier = durationFromSeconds(earlier_s);
  std::vector<Observation> changed;
  Pose2 last;
  std::size_t after = 1;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Stamp moment = observations[i].stamp - earlier;
    if (moment < observations.front().stamp || moment > observations.back().stamp) continue;
    while (after + 1 < observations.size() && observations[after].stamp < moment) ++after;
    while (after > 1 && observations[after - 1].stamp > moment) --after;
    const double interval_s = secondsBetween(observations[after - 1], observations[after]);
    const double fraction =
        secondsFromDuration(moment - observations[after - 1].stamp) / interval_s;
    const Pose2 pose = first_from_base[after - 1] *
                       partOf(observations[after].motion, fraction, wheel_separation_m);
    Observation observation = observations[i];
    observation.motion.start_from_end = last.inverse() * pose;
    last = pose;
    changed.push_back(observation);
  }
  return changed;
}

}  // namespace bearing_calibration::core
