#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace bearing_calibration::core {

/// What became of one input. Everything from kVarianceRaised on is to be heard of; from kNoStamp on
/// it is bad input: refused, counted, and without any other effect but the one that its comment
/// names.
enum class InputStatus : std::uint8_t {
  kAccepted,           ///< taken; bearings may still wait for the ticks that cover them
  kIgnoredPaused,      ///< the calibration is paused (ticks are still followed)
  kVarianceRaised,     ///< a stated variance was below the least: taken with that one
  kElevationLeftOut,   ///< beyond a right angle, most likely in degrees: taken without it
  kGeometryChanged,    ///< the sensor states another one, or knows less of it: a calibration anew
  kNoStamp,            ///< the stamp is zero
  kStampInFuture,      ///< the stamp lies after the time of receipt by more than allowed
  kStampNotAfterLast,  ///< the stamp is not later than the last one of its stream
  kAzimuthNotFinite,
  kAzimuthBeyondATurn,     ///< more than 2 pi: most likely in degrees
  kVarianceNotPositive,    ///< zero, negative or not finite
  kVarianceAbsurd,         ///< larger than the largest allowed, no information
  kProbabilityOutOfRange,  ///< not in [0, 1]
  kProbabilityZero,        ///< as where a sensor does not fill it in
  kGeometryAbsurd,         ///< a misalignment that is negative, or that no mirror has
  kGeometryUnmodelled,     ///< the paper's filter has no place for a misaligned mirror
  kViewImpossible,         ///< a field of view that is no part of a turn
  kCounterReset,       ///< the counters were reset by their driver: followed from the new value on
  kTicksTooFast,       ///< the wheels cannot have turned that far: refused, followed if it persists
  kTicksGap,           ///< no readings for so long that the counter may have wrapped unseen
  kTicksOutOfRange,    ///< the count does not fit the counter's width
  kAngleNotFinite,     ///< a joint position is not finite
  kPoseNotFinite,      ///< the odometry's pose is not finite
  kQuaternionNotUnit,  ///< the odometry's orientation is no rotation
  kFramesChanged,      ///< the odometry is not of the first message's frames
  kTwistWithoutPose,   ///< the odometry's pose stands while its twist moves: it is not integrated
  kMovedSideways,      ///< no wheels move the base so: refused, followed if it persists
  kNoPartner,          ///< one wheel's counter has no reading of the other wheel's beside it
  kQueueFull,          ///< too many bearings wait for ticks: the oldest one was dropped
  kTicksLost,          ///< ticks no longer cover the stamp of a waiting bearing
};
inline constexpr std::size_t kInputStatusCount =
    static_cast<std::size_t>(InputStatus::kTicksLost) + 1;

/// What became of one input, with the value that decided it (see describe()).
struct InputOutcome {
  InputStatus status = InputStatus::kAccepted;
  double value = 0.0;  ///< the offending value in SI units; seconds for stamps

  bool accepted() const { return status == InputStatus::kAccepted; }
  bool isBadInput() const { return status >= InputStatus::kNoStamp; }
  bool isWorthAWord() const { return status >= InputStatus::kVarianceRaised; }
};

/// A short name for counters and diagnostics, such as "variance not positive".
const char* nameOf(InputStatus status);

/// A sentence with the value and what was done, such as
/// "azimuth variance -0.1 rad^2 is not positive: candidate left out".
std::string describe(const InputOutcome& outcome);

/// How many inputs of one stream ended in which way.
struct InputCounts {
  std::array<std::uint32_t, kInputStatusCount> by_status{};

  std::uint32_t& operator[](InputStatus status) {
    return by_status[static_cast<std::size_t>(status)];
  }
  std::uint32_t operator[](InputStatus status) const {
    return by_status[static_cast<std::size_t>(status)];
  }
  std::uint32_t badInputs() const;
  std::uint32_t remarks() const;  ///< all that is worth a word: those, and what was changed
};

}  // namespace bearing_calibration::core
