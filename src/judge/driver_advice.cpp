#include "bearing_calibration/judge/driver_advice.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

/// A motion of this size tells the mount when it is varied; one that did not is degenerate.
constexpr double kPlentyOfPath_m = 3.0;
constexpr double kPlentyOfTurn_rad = 4.0 * kPi;

constexpr double kOfLate_s = 20.0;  // after which an image counts a third

/// "known least: +0.7 light x -0.7 sensor x, to 0.120 m"
std::string describe(const WeakestDirection& weakest) {
  static const char* const kNames[] = {"light x", "light y", "sensor x", "sensor y", "yaw"};
  constexpr double kWorthNaming = 0.3;  // of a unit vector
  std::string text = "known least:";
  for (int i = 0; i < 5; ++i) {
    if (std::abs(weakest.direction(i)) < kWorthNaming) continue;
    text += formatted(" %+.1f %s", weakest.direction(i), kNames[i]);
  }
  return text + formatted(", to %.3f m", weakest.stddev_m);
}

}  // namespace

bool isDegenerate(const StartAttempt& attempt) {
  const bool moved_plenty =
      attempt.motion.path_m > kPlentyOfPath_m || attempt.motion.turn_rad > kPlentyOfTurn_rad;
  switch (attempt.obstacle) {
    case StartObstacle::kTooShortPath:
    case StartObstacle::kNoTurn:
    case StartObstacle::kOneCurvature:
    case StartObstacle::kWeakDirection:
      return moved_plenty;
    default:
      return false;
  }
}

bool doesNotFit(const StartAttempt& attempt) {
  const bool moved_plenty =
      attempt.motion.path_m > kPlentyOfPath_m && attempt.motion.turn_rad > kPlentyOfTurn_rad;
  return moved_plenty && (attempt.obstacle == StartObstacle::kNoSolution ||
                          attempt.obstacle == StartObstacle::kPoorFit);
}

std::string adviceFor(const StartAttempt& attempt) {
  switch (attempt.obstacle) {
    case StartObstacle::kNone:  // a fault of the robot is looked for before it is believed
      return "a mount fits, but only with far more noise than is stated: keep driving";
    case StartObstacle::kTooFewObservations:
      return "keep the light in view and drive";
    case StartObstacle::kTooShortPath:
      return "drive about 1 m straight, then turn on the spot";
    case StartObstacle::kNoTurn:
      return "turn on the spot by a full turn, then drive straight";
    case StartObstacle::kOneCurvature:
      return "you are circling: drive about 1 m straight, then turn on the spot";
    case StartObstacle::kNoSolution:
      return "no mount explains the bearings yet: keep driving; if this stays, check that left and "
             "right wheel are not swapped, that the bearing grows counter-clockwise, and that no "
             "other light is in view";
    case StartObstacle::kPoorFit:
      return "the bearings fit the motion badly: check for slip, reflections and wheel geometry";
    case StartObstacle::kLightTooNear:
      return "the light seems too near: drive a metre straight, away from it, then turn";
    case StartObstacle::kWeakDirection:
      return "drive another metre nearer to the light and turn on the spot; " +
             describe(attempt.weakest);
    case StartObstacle::kAmbiguous:
      return "two mounts fit: drive straight and turn once more";
  }
  return "";
}

void TimeInView::add(const FieldOfView& view, Stamp stamp, bool is_seen) {
  constexpr double kLongest_s = 1.0;  // from one image to the next: longer, the sensor was silent
  view_ = view;
  const double time_s =
      last_ ? std::clamp(secondsFromDuration(stamp - *last_), 0.0, kLongest_s) : 0.0;
  last_ = stamp;
  const double kept = std::exp(-time_s / kOfLate_s);
  watched_s_ = kept * watched_s_ + time_s;
  seen_s_ = kept * seen_s_ + (is_seen ? time_s : 0.0);
}

std::string TimeInView::adviceWith(const std::string& advice) const {
  const bool is_known = view_.isLimited() && watched_s_ > 0.5 * kOfLate_s;
  if (!is_known || seen_s_ * 2.0 * kPi >= watched_s_ * view_.width_rad) return advice;
  constexpr double kPercent = 100.0;
  return formatted(
             "the light was in view in %.0f %% of the last images, and the sensor sees "
             "%.0f deg of a turn: keep it in view; ",
             kPercent * seen_s_ / watched_s_, degreesFromRadians(view_.width_rad)) +
         advice;
}

}  // namespace bearing_calibration::core
