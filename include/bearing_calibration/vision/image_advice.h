#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/light_detector.h"

namespace bearing_calibration::core {

/// What is wrong with exposure or focus.
enum class AdviceKind : std::uint8_t {
  kSaturated,      ///< many of the light's pixels are full
  kDim,            ///< the light uses a small part of the levels
  kNothingBright,  ///< nothing stands out of the background
  kTooCluttered,   ///< the whole image does
  kFocus,          ///< no light, but a spot as a lens focused elsewhere would make of it
  kNoneFits,       ///< bright spots, but none is like the light at any focus
};
inline constexpr std::size_t kAdviceKinds = 6;

/// For the person who sets up lens and exposure.
struct Advice {
  AdviceKind kind;
  std::string sentence;  ///< what is seen, with its figures, and what to change
};

/// The first thing to change in focus and exposure, by what the detector of this configuration saw
/// in an image; none when the light is seen as it should be.
std::optional<Advice> adviceFor(const DetectorConfig& config, const DetectionResult& result);

/// The focus distance at which the lens would make a spot of this size; all else as configured.
struct FocusGuess {
  double focus_distance_m = 0.0;  ///< infinity is allowed
  double misfit = 0.0;  ///< largest relative departure of a deviation from what is expected there
};
FocusGuess guessFocus(const DetectorConfig& config, const LightEllipse& ellipse);

/// The advice that holds for most images of a while: single images may be blurred or shaded.
class AdviceTally {
 public:
  void add(const std::optional<Advice>& advice);
  /// The newest advice of the kind that at least half of the images since the last call gave; none
  /// without one. Forgets them.
  std::optional<Advice> take();

 private:
  int images_ = 0;
  std::array<int, kAdviceKinds> counts_{};
  std::array<std::string, kAdviceKinds> sentences_;
};

}  // namespace bearing_calibration::core
