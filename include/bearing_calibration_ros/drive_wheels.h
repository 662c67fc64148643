#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "bearing_calibration/odometry/wheel_odometer.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration_ros/drive_params.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Wheel readings from any source, to the wheels' travel. Bad readings are no readings.
class DriveWheels {
 public:
  using OnTravel = std::function<void(const core::WheelTravel&)>;

  DriveWheels(const DriveNodeConfig& config, OnTravel on_travel)
      : config_(config), on_travel_(std::move(on_travel)) {
    restart();
  }

  /// @returns whether the readings' stamps have begun anew: none is used until they overtake the
  ///          last one, or until restart()
  template <typename Reading>
  bool add(const Reading& reading) {
    return haveBegunAnew(follow(reading), reading.stamp);
  }
  /// Of separate ticks. The left wheel's stamps alone tell: both would take turns.
  bool add(core::WheelSide side, const core::WheelCount& count) {
    const core::PairingOutcome outcome = pairing_->add(side, count);
    for (const core::WheelCounts& pair : outcome.pairs) follow(pair);
    return side == core::WheelSide::kLeft &&
           haveBegunAnew(outcome.refused.empty() ? core::InputOutcome() : outcome.refused.front(),
                         count.stamp);
  }

  /// The next reading is the first one.
  void restart() {
    pairing_.emplace(config_.geometry.counter_bits, config_.wheel_times.max_apart_s);
    odometer_.emplace(config_.geometry);
    stamp_watch_ = {};
  }

 private:
  template <typename Reading>
  core::InputOutcome follow(const Reading& reading) {
    const core::InputOutcome outcome = odometer_->add(reading);
    if (outcome.accepted()) on_travel_(*odometer_->travel());
    return outcome;
  }
  bool haveBegunAnew(const core::InputOutcome& outcome, core::Stamp stamp) {
    return stamp_watch_.hasBegunAnew(outcome, stamp, config_.drive.timeouts.ticks_s);
  }

  DriveNodeConfig config_;
  OnTravel on_travel_;
  std::optional<core::WheelPairing> pairing_;  ///< of separate ticks
  std::optional<core::WheelOdometer> odometer_;
  StampWatch stamp_watch_;
};

}  // namespace bearing_calibration_ros
