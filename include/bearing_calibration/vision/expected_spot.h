#pragma once

#include <vector>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {

struct Range {
  double low = 0.0;
  double high = 0.0;
};

/// Standard deviations of a light's image along the azimuth and along the mirror's radius, and how
/// far it is from evenly filled, for every distance that the light may have.
struct SpotSize {
  Range tangential_stddev_px;
  Range radial_stddev_px;
  double max_kurtosis = 0.0;  ///< fourth moment over squared second one, at most
};

/// At one image radius; at the rim's beyond it.
SpotSize expectedSpotSize(const DetectorConfig& config, double image_radius_px);

/// The image that the optics make of the light, tabulated over the image radius: the blur of the
/// open aperture, the light's own size, the pixels' size and the software's defocus. Nothing is
/// expected (zeros) when the mirror's gates are off.
class ExpectedSpot {
 public:
  explicit ExpectedSpot(const DetectorConfig& config);

  const SpotSize& at(double image_radius_px) const;
  /// Area [px] of the spots that can be seen anywhere in the mask.
  const Range& area_px() const { return area_px_; }
  /// Of those spots, along either axis.
  double largest_stddev_px() const { return largest_stddev_px_; }

 private:
  std::vector<SpotSize> sizes_;  ///< by image radius in whole pixels
  Range area_px_;
  double largest_stddev_px_ = 0.0;
};

}  // namespace bearing_calibration::core
