#include "bearing_calibration/odometry/odometry_window.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {

OdometryWindow::OdometryWindow(const std::array<WheelDisplacement, kSamples>& samples,
                               double wheel_separation_m)
    : samples_(samples), wheel_separation_m_(wheel_separation_m) {
  const WheelDisplacement zero = samples_[kBefore];
  for (WheelDisplacement& sample : samples_) {
    sample.left_m -= zero.left_m;
    sample.right_m -= zero.right_m;
  }
}

std::size_t OdometryWindow::intervalAt(double time_s) {
  const double steps = std::floor(time_s / kStep_s) + kBefore;
  return static_cast<std::size_t>(std::clamp(steps, 0.0, static_cast<double>(kSamples - 2)));
}

WheelDisplacement OdometryWindow::travelTo(double time_s) const {
  const std::size_t i = intervalAt(time_s);
  const WheelSpeeds speeds = speedsAt(time_s);
  const double since_s = time_s - (static_cast<double>(i) - kBefore) * kStep_s;
  return {samples_[i].left_m + speeds.left_mps * since_s,
          samples_[i].right_m + speeds.right_mps * since_s};
}

WheelSpeeds OdometryWindow::speedsAt(double time_s) const {
  const std::size_t i = intervalAt(time_s);
  return {(samples_[i + 1].left_m - samples_[i].left_m) / kStep_s,
          (samples_[i + 1].right_m - samples_[i].right_m) / kStep_s};
}

}  // namespace bearing_calibration::core
