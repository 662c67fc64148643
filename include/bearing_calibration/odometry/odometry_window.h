#pragma once

#include <array>
#include <cstddef>

#include "bearing_calibration/odometry/odometry_increment.h"

namespace bearing_calibration::core {

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
