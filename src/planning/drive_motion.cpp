#include "bearing_calibration/planning/drive_motion.h"

#include <algorithm>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSide_m = 1.0;           // the paper's
constexpr double kDanceTurn = 2.5 * kPi;  // 450 degrees, the paper's
constexpr double kFullTurn = 2.0 * kPi;

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

const MotionPrimitive& PrimitiveSequence::at(std::size_t i) const {
  if (i < primitives.size()) return primitives[i];
  return primitives[repeat_from + (i - repeat_from) % (primitives.size() - repeat_from)];
}

PrimitiveSequence openingPrimitives() {
  return {{{kFullTurn, 0.0}, {0.0, kSide_m}, {kFullTurn, 0.0}, {kDanceTurn, kSide_m}}, 3};
}

PrimitiveSequence scriptedPrimitives(DriveMotion motion) {
  if (motion == DriveMotion::kOptimal) {
    throw std::invalid_argument("the optimal motion has no script");
  }
  return {{{0.0, kSide_m}, {kDanceTurn, kSide_m}}, 1};
}

std::vector<std::string> instructionsFor(DriveMotion motion) {
  const std::vector<std::string> dance = {
      "Drive 1 m straight on.",
      "Turn on the spot to the left by one turn and a quarter (450 degrees).",
      "Do both again, slowly and with the light in view, until the calibration says CONVERGED."};
  std::vector<std::string> steps;
  switch (motion) {
    case DriveMotion::kOptimal:
      return {"This motion is planned while it is driven, by the robot itself."};
    case DriveMotion::kDance:
      steps = {
          "Put the light about two metres to the robot's left: the robot will drive a square "
          "of 1 m, always turning left."};
      break;
    case DriveMotion::kCornerLight:
      steps = {
          "The robot will drive a square of 1 m, always turning left. Put the light inside of "
          "it, half a metre ahead of the robot and near its first side: the standard "
          "deviations of the mount are nearly proportional to the light's distance."};
      break;
  }
  steps.insert(steps.end(), dance.begin(), dance.end());
  return steps;
}

}  // namespace bearing_calibration::core
