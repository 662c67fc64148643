#pragma once

#include <cstdint>
#include <optional>

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
  kHorizon,         ///< above the mirror's apex
  kTangentialSize,  ///< not the blur that the optics make
  kRadialSize,
  kAxis,          ///< not along the mirror's radius
  kKurtosis,      ///< brighter in the middle than what an open aperture makes of a light
  kUnlikely,      ///< inside of every gate, but near too many of them
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

/// How far a measured ellipse is from a light's, each in units of its gate: 1 or -1 is on its edge.
struct PartsOfGates {
  double fill = 0.0;
  double tangential = 0.0;  ///< this and the others only with the mirror's gates
  double radial = 0.0;
  double kurtosis = 0.0;
  std::optional<double> axis;  ///< where a light has one
};
PartsOfGates partsOfGates(const LightEllipse& ellipse, const SpotSize& expected,
                          const GateConfig& gates);

/// The gates that need the measured ellipse.
Rejection rejectionOf(const PartsOfGates& parts);

/// Probability in 0 to 1 that an ellipse which passed the gates is a light rather than clutter:
/// a light's fill, sizes and axis scatter about the expected ones as a normal distribution with the
/// gates at three sigma, clutter's are anything inside the gates; both equally likely beforehand.
/// It says how much like a light the spot is, not which of several lights it is.
double probabilityOf(const PartsOfGates& parts, const GateConfig& gates);

}  // namespace bearing_calibration::core
