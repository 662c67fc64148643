#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// Brightness of the far surroundings by direction: azimuth [rad] in the world frame, elevation
/// [rad] over the horizon. In full wells of a pixel at the camera's exposure, 0 and more.
using RadianceFunction = std::function<double(double azimuth_rad, double elevation_rad)>;

/// A table of a radiance function, turned and read quickly.
class Panorama {
 public:
  struct Extent {
    double lowest_rad = 0.0;  ///< elevations that are looked up
    double highest_rad = 0.0;
    double azimuth_blur_rad = 0.0;  ///< standard deviations of the optics' defocus
    double elevation_blur_rad = 0.0;
  };
  /// Where in the table a direction lies.
  struct Place {
    float column = 0.0F;  ///< of the azimuth, in [0, kColumns)
    std::int32_t row = -1;
  };
  static constexpr int kColumns = 2048;  ///< 0.18 degrees, finer than a pixel of the mirror's image
  static constexpr int kRows = 256;

  Panorama(const RadianceFunction& radiance, const Extent& extent);

  Place placeOf(double azimuth_rad, double elevation_rad) const;
  /// Radiance at `place` turned by `columns_turned` in [0, kColumns).
  float at(const Place& place, float columns_turned) const {
    float column = place.column + columns_turned;
    if (column >= static_cast<float>(kColumns)) column -= static_cast<float>(kColumns);
    const int left = static_cast<int>(column);
    const float* values = &table_(place.row, left);
    return values[0] + (column - static_cast<float>(left)) * (values[1] - values[0]);
  }
  /// How far a turn of the sensor shifts the columns.
  static float columnsFrom(double yaw_rad);

 private:
  Extent extent_;
  cv::Mat1f table_;  ///< the first column again at the end
};

/// A room: floor, walls with large soft differences of brightness around, and a lighter ceiling.
struct RoomLook {
  double brightness = 0.05;  ///< of the walls at the horizon [full wells]
  double contrast = 0.5;     ///< of the differences around, 0 to 1
  std::uint64_t seed = 1;

  void declare(Parameters& params);
};
RadianceFunction roomRadiance(const RoomLook& look);

}  // namespace bearing_calibration::core
