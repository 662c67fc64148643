#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "bearing_calibration/planning/drive_motion.h"

namespace bearing_calibration::core {

/// Deals out the primitives of a motion that is driven as it is written down, and of the opening of
/// one that is planned. The little that a turn has missed is made up for by the next one.
class DriveScript {
 public:
  explicit DriveScript(DriveMotion motion);

  /// The next primitive. None when it is not allowed; but an opening turns to where there is room,
  /// and goes half the way where there is not.
  /// @param turned_rad  by how much the base has turned since the script began, full turns too
  std::optional<MotionPrimitive> next(
      double turned_rad, const std::function<bool(const MotionPrimitive&)>& is_allowed);

 private:
  PrimitiveSequence primitives_;
  bool may_change_;
  std::size_t next_ = 0;
  double heading_rad_ = 0.0;  ///< where the primitives so far have led, counted as turned_rad is
};

}  // namespace bearing_calibration::core
