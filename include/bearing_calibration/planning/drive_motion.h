#pragma once

#include <cstdint>
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

/// Hops that are driven in their order; from `repeat_from` on again and again.
struct PrimitiveSequence {
  std::vector<MotionPrimitive> primitives;
  std::size_t repeat_from = 0;

  const MotionPrimitive& at(std::size_t i) const;
};

/// What is safe to drive, and enough to find mount and light, while nothing is known: a spin, a
/// metre, a spin; and if that was not enough, the dance from there on.
PrimitiveSequence openingPrimitives();
/// The primitives of a scripted motion. @throws std::invalid_argument for kOptimal.
PrimitiveSequence scriptedPrimitives(DriveMotion motion);

/// The same for a person who drives by hand: one line for each step, with the place of the light.
std::vector<std::string> instructionsFor(DriveMotion motion);

}  // namespace bearing_calibration::core
