#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"

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

/// The pixels in which a light may be seen: the mirror's annulus less its posts and the rows that
/// are not valid, kept as strips in reading order.
class AnnulusMask {
 public:
  AnnulusMask(const MaskConfig& config, const MirrorView& view, const ImageSensor& sensor);

  const std::vector<PixelStrip>& strips() const { return strips_; }

  /// Writes the part of the mask inside `sector` to `strips`, without allocation once that has
  /// the capacity. @throws std::invalid_argument unless 0 < half width < 90 deg.
  void clipToSector(const AzimuthSector& sector, std::vector<PixelStrip>* strips) const;

  /// The same for the part of the mask inside `box`.
  void clipToBox(const cv::Rect& box, std::vector<PixelStrip>* strips) const;

  /// Whole pixels from the pixel nearest to a position to the nearest one outside of the mask; 0
  /// for a pixel that is outside itself, and not more than 255.
  int clearancePx(double u_px, double v_px) const;
  bool contains(double u_px, double v_px) const { return clearancePx(u_px, v_px) > 0; }

 private:
  template <typename Narrow>
  void clip(double first_row, double last_row, Narrow narrow,
            std::vector<PixelStrip>* strips) const;

  MirrorView view_;
  int width_px_;
  int height_px_;
  double outer_radius_px_;
  std::vector<PixelStrip> strips_;
  cv::Mat clearance_;  ///< by pixel, CV_8UC1
};

}  // namespace bearing_calibration::core
