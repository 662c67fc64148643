#pragma once

#include <array>
#include <cstdint>

#include "bearing_calibration/vision/annulus_mask.h"
#include "bearing_calibration/vision/blob_segmenter.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"
#include "bearing_calibration/vision/light_ellipse.h"

namespace bearing_calibration::core {

/// Why a bright spot is not taken for the light.
enum class Rejection : std::uint8_t {
  kNone,
  kTooFewPixels,
  kTooManyPixels,
  kFill,            ///< not an ellipse
  kMaskEdge,        ///< cut by the mask's edge or by a post
  kNoLight,         ///< nothing is left over the background
  kHorizon,         ///< higher than a light may be
  kTangentialSize,  ///< not the blur that the optics make
  kRadialSize,
  kAxis,          ///< not along the mirror's radius
  kKurtosis,      ///< brighter in the middle than what an open aperture makes of a light
  kUnlikely,      ///< by several small doubts
  kTooManySpots,  ///< not measured: the image has more spots than max_candidates
};
inline constexpr int kRejections = 13;

/// A few words for people.
const char* describe(Rejection rejection);

/// How far the fill of a spot of few pixels may be from an ellipse's beyond the gate.
double fillTolerance(const BlobShape& shape);

/// The gates that need only the thresholded pixels.
Rejection rejectionOf(const Blob& blob, const BlobShape& shape, const GateConfig& gates,
                      const Range& area_px);

/// How a spot was found: the more was tried, the less it says.
struct Search {
  bool opened = false;  ///< beside bright areas, which were taken away
  double threshold_levels = 0.0;
  int thresholds = 1;              ///< of which this is the last
  int spots = 0;                   ///< over the threshold
  double log_part_searched = 0.0;  ///< logarithm of the part of the mask that was searched
};

/// By how much one measure of a spot lowers the logarithm of its odds to be a light.
struct Doubt {
  Rejection reason = Rejection::kUnlikely;
  double log_odds = 0.0;
};
using Doubts = std::array<Doubt, 8>;
Doubts doubtsAbout(const LightEllipse& ellipse, const SpotSize& expected, const Search& search,
                   const GateConfig& gates);

/// Probability in 0 to 1 that a spot is a light rather than clutter. It says how much like a light
/// the spot is, not which of several lights it is.
double probabilityOf(const Doubts& doubts, const Search& search);

/// The reason of the largest of them; kUnlikely where none is large.
Rejection largestOf(const Doubts& doubts);

}  // namespace bearing_calibration::core
