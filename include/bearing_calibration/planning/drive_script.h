#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/planning/motion_primitive.h"

namespace bearing_calibration::core {

/// How to drive a calibration.
enum class DriveMotion : std::uint8_t {
  kOptimal,      ///< planned on the estimate as it grows
  kDance,        ///< the paper's second trajectory: a metre, a spin of 450 degrees, and again
  kCornerLight,  ///< the same with the light inside the square that this drives, near a corner
};

/// "optimal", "dance", "corner_light", in their order.
const std::vector<std::string>& motionNames();
/// None when no motion is called so.
std::optional<DriveMotion> motionNamed(const std::string& name);
/// A motion for a person who drives by hand: one line for each step, with the place of the light.
std::vector<std::string> instructionsFor(DriveMotion motion);

/// Deals out the primitives of a motion that is driven as it is written down. Of one that is
/// planned, they are its opening: what is safe to drive, and enough to find mount and light, while
/// nothing is known. What a turn has missed is made up for by the next one.
class DriveScript {
 public:
  explicit DriveScript(DriveMotion motion);

  /// The next primitive. None when it is not allowed; but an opening turns to where there is room,
  /// and goes half the way where there is not.
  /// @param turned_rad  by how much the base has turned since the script began, full turns too
  std::optional<MotionPrimitive> next(
      double turned_rad, const std::function<bool(const MotionPrimitive&)>& is_allowed);

 private:
  bool is_opening_;
  std::vector<MotionPrimitive> beginning_;  ///< before the dance, which has no end
  std::size_t next_ = 0;
  double heading_rad_ = 0.0;  ///< where the primitives so far have led, counted as turned_rad is
};

}  // namespace bearing_calibration::core
