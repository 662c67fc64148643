#include "tools/study/fault_cases.h"

#include <utility>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

void leaveSound(SimulatedCase* /*simulated*/) {}

void swapWheels(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) std::swap(ticks.left_ticks, ticks.right_ticks);
  };
}

void reverseLeft(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) ticks.left_ticks = -ticks.left_ticks;
  };
}

void reverseRight(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) ticks.right_ticks = -ticks.right_ticks;
  };
}

void turnBearingsClockwise(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (BearingSet& image : record->bearings) {
      for (Bearing& bearing : image.candidates) bearing.azimuth_rad = -bearing.azimuth_rad;
    }
  };
}

void delayCamera(SimulatedCase* simulated) {
  constexpr double kLate_s = 0.1;
  simulated->robot.stamp_latency_s = kLate_s;
}

void enlargeRightWheel(SimulatedCase* simulated) {
  constexpr double kFactor = 1.1;  // true over believed
  simulated->robot.encoders.right_radius_factor = kFactor;
}

void enlargeSeparation(SimulatedCase* simulated) {
  constexpr double kFactor = 1.1;  // true over believed
  simulated->robot.separation_factor = kFactor;
}

/// As where other edges of a tick count than the owner believes, or a diameter is given for a
/// radius.
template <int kTimes>
void countMoreTicks(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) {
      ticks.left_ticks *= kTimes;
      ticks.right_ticks *= kTimes;
    }
  };
}

/// From a moment on, what another robot of the same drive would have seen.
void becomeAfter(double seconds, const SimulatedCase& other, SimulatedCase* simulated) {
  simulated->change_record = [seconds, other](SimulatedRecord* record) {
    const SimulatedRecord later = simulate(other).record;
    const Stamp since = record->ticks.front().stamp + durationFromSeconds(seconds);
    for (std::size_t i = 0; i < record->bearings.size(); ++i) {
      if (record->bearings[i].stamp >= since) record->bearings[i] = later.bearings[i];
    }
  };
}

void moveLight(SimulatedCase* simulated) {
  constexpr double kAfter_s = 30.0;
  SimulatedCase moved = *simulated;
  moved.lights[0].position_m += Eigen::Vector2d(0.6, -0.8);
  becomeAfter(kAfter_s, moved, simulated);
}

void displaceMount(SimulatedCase* simulated) {
  constexpr double kAfter_s = 100.0;  // CONVERGED
  SimulatedCase displaced = *simulated;
  displaced.robot.base_from_sensor.position_m.x() += 0.02;
  displaced.robot.base_from_sensor.yaw_rad += radiansFromDegrees(5.0);
  becomeAfter(kAfter_s, displaced, simulated);
}

}  // namespace

const std::vector<FaultCase>& faultCases() {
  static const std::vector<FaultCase> kCases = {
      {"none", Fault::kNone, leaveSound},
      {"left and right swapped", Fault::kMirrored, swapWheels},
      {"azimuth clockwise", Fault::kMirrored, turnBearingsClockwise},
      {"left reversed", Fault::kLeftReversed, reverseLeft},
      {"right reversed", Fault::kRightReversed, reverseRight},
      {"camera 0.1 s late", Fault::kLate, delayCamera},
      {"right wheel 10 % larger", Fault::kRightRadius, enlargeRightWheel},
      {"separation 10 % larger", Fault::kSeparation, enlargeSeparation},
      {"ticks counted twice", Fault::kSeparation, countMoreTicks<2>},
      {"ticks counted four times", Fault::kSeparation, countMoreTicks<4>},
      {"light moved by 1 m after 30 s", Fault::kLightMoved, moveLight},
      {"mount displaced by 2 cm and 5 deg after 100 s", Fault::kMountMoved, displaceMount, false},
  };
  return kCases;
}

}  // namespace bearing_calibration::core
