#pragma once

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

/// What no robot needs, from one of millimetres to a truck, and no room: a parameter beyond has a
/// wrong unit or a slip of the keyboard, and its arithmetic would fail long after the start.
namespace plausible {

inline constexpr double kShortest_m = 1e-4;
inline constexpr double kFarthest_m = 1000.0;
inline constexpr double kFastest_mps = 100.0;
inline constexpr double kSlowest_mps = 1e-4;
inline constexpr double kFastestTurn_radps = 100.0;
inline constexpr double kBriefest_s = 1e-3;
inline constexpr double kLongest_s = 86400.0;        // a day
inline constexpr double kLongestHistory_s = 3600.0;  // of wheel readings: 360000 at 100 Hz
inline constexpr double kRarest_hz = 1e-3;
inline constexpr double kMostFrequent_hz = 1e4;
inline constexpr double kTurn_rad = 2.0 * kPi;
inline constexpr double kLeastAngle_rad = 1e-9;  // of a standard deviation; a simulated sensor's
inline constexpr double kLeastLength_m = 1e-9;   // the same
inline constexpr double kMostSigmas = 1000.0;
inline constexpr double kLargestRatio = 100.0;  // of two things that should be of one size
// Of an image: wider ones are stitched or wrong; integer moments and memory are made for this.
inline constexpr double kLargestSide_px = 16384.0;
inline constexpr int kMostOfAKind = 1000000;  // bearings, images: a day of them

}  // namespace plausible
}  // namespace bearing_calibration::core
