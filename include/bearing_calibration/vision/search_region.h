#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detection.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

/// Pixels [begin, end) of a row.
struct PixelStrip {
  int row = 0;
  int begin = 0;
  int end = 0;
};

/// Directions within half_width_rad < 90 deg of the centre.
struct AzimuthSector {
  double centre_rad = 0.0;
  double half_width_rad = 0.0;
};

/// The pixels in which a light may be seen: the mirror's annulus less its posts, or the whole image
/// without a mirror, and less the rows that are not valid, kept as strips in reading order.
class AnnulusMask {
 public:
  explicit AnnulusMask(const DetectorConfig& config);

  const std::vector<PixelStrip>& strips() const { return strips_; }

  /// The part of the mask inside a sector or a box, written to `strips`.
  /// @throws std::invalid_argument unless 0 < half width < 90 deg
  void clipToSector(const AzimuthSector& sector, std::vector<PixelStrip>* strips) const;
  void clipToBox(const cv::Rect& box, std::vector<PixelStrip>* strips) const;

  /// Whether the pixel nearest to a position is one of them.
  bool contains(double u_px, double v_px) const;
  /// Whether the ellipse's outline leaves the mask.
  bool cuts(const PixelEllipse& ellipse) const;

 private:
  MirrorView view_;
  double outer_radius_px_;
  std::vector<PixelStrip> strips_;
  cv::Mat1b inside_;  ///< by pixel
};

/// Where in an image a light is expected, by the place of its centre.
struct ExpectedPlace {
  MirrorPixel centre;
  double half_width_rad = 0.0;
  double half_height_px = 0.0;  ///< along the mirror's radius
};

/// Where a light is looked for before the whole mask is.
struct SearchRegion {
  std::optional<ExpectedPlace> place;  ///< first, as far as the light's own image reaches around it
  AzimuthSector sector;                ///< then, at any radius
};

/// The image radius at which the light was last seen.
struct SeenRadius {
  Stamp stamp;
  double radius_px = 0.0;
  double radius_variance_px2 = 0.0;
};

/// Of the candidate nearest to the prediction; nothing without any.
std::optional<SeenRadius> seenRadius(const BearingSet& bearings,
                                     const BearingPrediction& prediction);

/// How far a prediction of the bearing narrows the search. Parameter group `prediction`.
struct SearchConfig {
  bool use = false;
  double sigmas = 0.0;      ///< half the region's width in the prediction's deviations
  double margin_rad = 0.0;  ///< added to the sector on either side: at least the light's own image
  double max_age_s = 0.0;   ///< an older prediction says nothing
  double max_turn_rate_radps = 0.0;   ///< of the bearing: widens the region with the age
  double max_radius_rate_pxps = 0.0;  ///< of the image radius since the light was seen

  void declare(Parameters& params);
};

/// Where the light is expected in an image of `stamp`; nothing without a useful prediction, the
/// sector alone when the light was not seen lately.
std::optional<SearchRegion> searchRegion(const SearchConfig& config,
                                         const BearingPrediction& prediction,
                                         const std::optional<SeenRadius>& seen, Stamp stamp);

/// All pixels of a light whose centre is where it is expected, with room for a dark rim: the box
/// around a rectangle of centres, along and across the mirror's radius, and the largest ellipse
/// about each.
cv::Rect boxAround(const ExpectedPlace& place, const ExpectedSpot& expected,
                   const DetectorConfig& config);

}  // namespace bearing_calibration::core
