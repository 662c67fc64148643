#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration {

/// Pixels [begin, end) of one row.
struct PixelInterval {
  int row = 0;
  int begin = 0;
  int end = 0;
};

/// Directions within half_width_rad < 90 deg of the centre.
struct AzimuthSector {
  double centre_rad = 0.0;
  double half_width_rad = 0.0;
};

/// The pixels in which a light may be seen: the mirror's annulus less its posts and the rows that
/// are not valid, kept as intervals in reading order.
class AnnulusMask {
 public:
  AnnulusMask(const MaskConfig& config, const MirrorView& view, const ImageSensor& sensor);

  const std::vector<PixelInterval>& intervals() const { return intervals_; }

  /// Writes the part of the mask inside `sector` to `intervals`, without allocation once that has
  /// the capacity. @throws std::invalid_argument unless 0 < half width < 90 deg.
  void clip(const AzimuthSector& sector, std::vector<PixelInterval>* intervals) const;

  /// True for a pixel of the mask; the position is rounded to the nearest pixel.
  bool contains(double u_px, double v_px) const;

 private:
  MirrorView view_;
  int width_px_;
  int height_px_;
  double outer_radius_px_;
  std::vector<PixelInterval> intervals_;
  std::vector<std::uint8_t> inside_;  ///< the same by pixel
};

}  // namespace bearing_calibration
