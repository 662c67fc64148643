#include "bearing_calibration/planning/drive_script.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

/// Courses that are tried when the one that the opening wants is not allowed.
constexpr double kCourseStep = 0.25 * kPi;
constexpr int kCourses = 8;
/// What a primitive may miss of its turn; when it is more, something else has been driven
/// meanwhile.
constexpr double kMostMissed_rad = 0.2;

}  // namespace

DriveScript::DriveScript(DriveMotion motion)
    : primitives_(motion == DriveMotion::kOptimal ? openingPrimitives()
                                                  : scriptedPrimitives(motion)),
      may_change_(motion == DriveMotion::kOptimal) {}

std::optional<MotionPrimitive> DriveScript::next(
    double turned_rad, const std::function<bool(const MotionPrimitive&)>& is_allowed) {
  const MotionPrimitive& wanted = primitives_.at(next_++);
  if (std::abs(heading_rad_ - turned_rad) > kMostMissed_rad) heading_rad_ = turned_rad;
  const int courses = may_change_ ? kCourses : 1;
  for (const double share : {1.0, 0.5}) {
    for (int i = 0; i < courses; ++i) {
      const double heading_rad = heading_rad_ + wanted.turn_rad + i * kCourseStep;
      const MotionPrimitive primitive{heading_rad - turned_rad, share * wanted.length_m};
      if (!is_allowed(primitive)) continue;
      heading_rad_ = heading_rad;
      return primitive;
    }
    if (!may_change_) break;
  }
  return std::nullopt;
}

}  // namespace bearing_calibration::core
