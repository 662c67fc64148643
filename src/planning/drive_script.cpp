#include "bearing_calibration/planning/drive_script.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr double kFullTurn = 2.0 * kPi;
constexpr double kSide_m = 1.0;                                   // the paper's
constexpr MotionPrimitive kDanceStep{1.25 * kFullTurn, kSide_m};  // 450 degrees, the paper's
/// Courses that are tried when the one that the opening wants is not allowed.
constexpr double kCourseStep = 0.25 * kPi;
constexpr int kCourses = 8;
/// What a primitive may miss of its turn (1 rad on a small robot whose readings are 0.3 s late);
/// when it is more, something else has been driven meanwhile.
constexpr double kMostMissed_rad = 0.5 * kPi;

}  // namespace

const std::vector<std::string>& motionNames() {
  static const std::vector<std::string> names = {"optimal", "dance", "corner_light"};
  return names;
}

std::optional<DriveMotion> motionNamed(const std::string& name) {
  const std::vector<std::string>& names = motionNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<DriveMotion>(found - names.begin());
}

std::vector<std::string> instructionsFor(DriveMotion motion) {
  if (motion == DriveMotion::kOptimal) {
    return {"This motion is planned while it is driven, by the robot itself."};
  }
  return {
      motion == DriveMotion::kDance
          ? "Put the light about two metres to the robot's left: the robot will drive a square "
            "of 1 m, always turning left."
          : "The robot will drive a square of 1 m, always turning left. Put the light inside of "
            "it, half a metre ahead of the robot and near its first side: the standard "
            "deviations of the mount are nearly proportional to the light's distance.",
      "Drive 1 m straight on.",
      "Turn on the spot to the left by one turn and a quarter (450 degrees).",
      "Do both again, slowly and with the light in view, until the calibration says CONVERGED."};
}

DriveScript::DriveScript(DriveMotion motion)
    : is_opening_(motion == DriveMotion::kOptimal), beginning_{{0.0, kSide_m}} {
  if (is_opening_) beginning_ = {{kFullTurn, 0.0}, {0.0, kSide_m}, {kFullTurn, 0.0}};
}

std::optional<MotionPrimitive> DriveScript::next(
    double turned_rad, const std::function<bool(const MotionPrimitive&)>& is_allowed) {
  const bool is_first = next_ == 0;  // what has turned before is the braking of another drive
  const MotionPrimitive wanted = next_ < beginning_.size() ? beginning_[next_++] : kDanceStep;
  if (is_first || std::abs(heading_rad_ - turned_rad) > kMostMissed_rad) {
    heading_rad_ = turned_rad;
  }
  for (const double share : {1.0, 0.5}) {
    for (int i = 0; i < kCourses; ++i) {
      const double heading_rad = heading_rad_ + wanted.turn_rad + i * kCourseStep;
      const MotionPrimitive primitive{heading_rad - turned_rad, share * wanted.length_m};
      if (is_allowed(primitive)) {
        heading_rad_ = heading_rad;
        return primitive;
      }
      if (!is_opening_) return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace bearing_calibration::core
