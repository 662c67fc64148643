#include "bearing_calibration/planning/drive_end.h"

#include <array>
#include <cstddef>

namespace bearing_calibration::core {
namespace {

struct Words {
  const char* name;
  const char* sentence;
};

const Words& wordsFor(DriveEnd end) {
  static constexpr std::array<Words, 18> kWords{{
      {"DRIVING", "the robot drives"},
      {"CONVERGED", "the calibration has converged"},
      {"CANCELLED", "the drive was cancelled"},
      {"DISABLED", "~enable is false: no drive until it is true"},
      {"OBSTACLE", "an obstacle was reported: clear the way, then start again"},
      {"TICKS_LOST", "no wheel readings: check the wheel driver"},
      {"LIGHT_LOST", "the light is not seen: check the lamp, the detector and what stands between"},
      {"ESTIMATE_LOST", "the calibration is silent: check its node"},
      {"CLOCK_LOST", "/clock stands still"},
      {"LEFT_REGION", "the robot has left its region: put it back, then start again"},
      {"NO_WAY", "every path leads too near to the light or out of the region: give more room"},
      {"WHEELS_DISOBEYED",
       "the wheels do not roll as commanded: check cmd_vel, and whether they are swapped"},
      {"TIME_OVER", "the time of this drive is over"},
      {"PATH_OVER", "the path of this drive is over"},
      {"SHUT_DOWN", "the drive node was asked to end"},
      {"ENABLE_LOST", "~enable is silent: its publisher must repeat it (timeouts/enable)"},
      {"OBSTACLE_LOST", "obstacle is silent: its publisher must repeat it (timeouts/obstacle)"},
      {"FAILED", "an error inside the drive node: see its log"},
  }};
  return kWords.at(static_cast<std::size_t>(end));
}

}  // namespace

const char* nameOf(DriveEnd end) { return wordsFor(end).name; }
const char* describe(DriveEnd end) { return wordsFor(end).sentence; }

}  // namespace bearing_calibration::core
