#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/drive_geometry.h"

namespace bearing_calibration::core {

/// How far each wheel has rolled between two moments; forward is positive.
struct WheelDisplacement {
  double left_m = 0.0;
  double right_m = 0.0;
};

/// How fast each wheel rolls.
struct WheelSpeeds {
  double left_mps = 0.0;
  double right_mps = 0.0;
};

/// The motion of the base between two moments, pre-integrated over any number of arcs.
struct OdometryIncrement {
  Pose2 start_from_end;  ///< the base's pose at the end, in the base frame of the start
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of start_from_end (x, y, yaw)
  double distance_m = 0.0;                               ///< path length of the base's centre, >= 0
  double rotation_rad = 0.0;                             ///< sum of the absolute turns, >= 0
  /// d(x, y, yaw) / d(left, right, separation), each as a relative error of what was believed: the
  /// motion as it would be with other wheels, without integrating it again. Its last entry is minus
  /// the whole turn, not wrapped.
  Eigen::Matrix3d J_pose_wheels = Eigen::Matrix3d::Zero();
  /// The covariance is, in part, of motion that nobody has seen: no noise of the wheels, which may
  /// be smaller than stated.
  bool has_unseen = false;

  /// The turn is known too badly for a linearised filter to follow.
  bool isTurnUnknown() const {
    constexpr double kUnknownStddev_rad = 0.5;
    return covariance(2, 2) > kUnknownStddev_rad * kUnknownStddev_rad;
  }
};

/// One arc of constant curvature with its Jacobian.
struct Arc {
  Pose2 start_from_end;
  Eigen::Matrix<double, 3, 2> J_pose_wheels;  ///< d(x, y, yaw) / d(left_m, right_m)
};

/// The exact arc of a differential drive (model.md, eq. 2).
Arc arcFromWheels(const WheelDisplacement& wheels, double wheel_separation_m);

/// The arc that ends at a pose, for turns of up to a half: the inverse of arcFromWheels(). What of
/// the position lies across the arc's chord is left out.
WheelDisplacement wheelsFromArc(const Pose2& start_from_end, double wheel_separation_m);

/// Appends one arc to an increment, the covariance with it (model.md, eq. 4).
/// `unseen_variance_m2` is added for each wheel, for motion that a break in the readings has
/// hidden.
OdometryIncrement append(const OdometryIncrement& increment, const WheelDisplacement& wheels,
                         double wheel_separation_m, const WheelNoise& noise,
                         double unseen_variance_m2 = 0.0);

/// The motion of two increments, one after the other; their errors are independent.
OdometryIncrement append(const OdometryIncrement& first, const OdometryIncrement& second);

/// The wheels' travel in a short stretch of time around a moment, relative to that moment: what a
/// bearing needs to be moved to another time of its own.
class OdometryWindow {
 public:
  static constexpr double kStep_s = 0.025;  ///< between two samples
  static constexpr int kBefore = 12;        ///< samples before the moment: cameras are late
  static constexpr int kAfter = 8;          ///< samples after it
  static constexpr int kSamples = kBefore + 1 + kAfter;

  /// No motion at all.
  OdometryWindow() = default;
  /// @param samples  travel at the moment plus (i - kBefore) kStep_s; its zero does not matter.
  /// @param wheel_separation_m  as believed
  OdometryWindow(const std::array<WheelDisplacement, kSamples>& samples, double wheel_separation_m);
  /// The same with other wheels, as (left, right) from (left, right).
  OdometryWindow withOtherWheels(const Eigen::Matrix2d& wheels_from_wheels,
                                 double wheel_separation_m) const;

  /// Travel from the moment to `time_s` after it (negative: before it). Outside of the samples the
  /// nearest speed goes on.
  WheelDisplacement travelTo(double time_s) const;
  WheelSpeeds speedsAt(double time_s) const;
  double wheelSeparation() const { return wheel_separation_m_; }

 private:
  /// The samples' interval that a moment lies in, or is nearest to.
  static std::size_t intervalAt(double time_s);

  std::array<WheelDisplacement, kSamples> samples_{};
  double wheel_separation_m_ = 1.0;  ///< any: without travel it has no effect
};

}  // namespace bearing_calibration::core
