#include "bearing_calibration/simulation/panorama.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/simulation/random_numbers.h"

namespace bearing_calibration::core {
namespace {

constexpr double kRadiansPerColumn = 2.0 * kPi / Panorama::kColumns;

/// Cells on each side that a Gaussian blur takes in.
int reachOf(double stddev_cells) {
  constexpr double kReach = 3.0;  // standard deviations; 0.3 % of the weight lies beyond
  return static_cast<int>(std::ceil(kReach * stddev_cells));
}

}  // namespace

Panorama::Panorama(const RadianceFunction& radiance, const Extent& extent) : extent_(extent) {
  const double radians_per_row = (extent.highest_rad - extent.lowest_rad) / (kRows - 1);
  const double columns_blur = extent.azimuth_blur_rad / kRadiansPerColumn;
  const double rows_blur =
      radians_per_row > 0.0 ? extent.elevation_blur_rad / radians_per_row : 0.0;
  const int beside = reachOf(columns_blur);
  const int above = reachOf(rows_blur);
  // Rows beyond the table's edge count in the blur of its rows.
  cv::Mat1d sharp(kRows + 2 * above, kColumns);
  for (int row = 0; row < sharp.rows; ++row) {
    const double elevation = extent.lowest_rad + (row - above) * radians_per_row;
    for (int column = 0; column < kColumns; ++column) {
      sharp(row, column) = radiance(column * kRadiansPerColumn, elevation);
    }
  }
  cv::Mat1d blurred;
  cv::copyMakeBorder(sharp, blurred, 0, 0, beside, beside + 1, cv::BORDER_WRAP);
  cv::GaussianBlur(blurred, blurred, {2 * beside + 1, 2 * above + 1}, columns_blur, rows_blur);
  blurred(cv::Rect(beside, above, kColumns + 1, kRows)).convertTo(table_, CV_32F);
}

float Panorama::columnsFrom(double yaw_rad) {
  double columns = wrapAngle(yaw_rad) / kRadiansPerColumn;
  if (columns < 0.0) columns += kColumns;
  const float result = static_cast<float>(columns);
  return result < static_cast<float>(kColumns) ? result : 0.0F;
}

Panorama::Place Panorama::placeOf(double azimuth_rad, double elevation_rad) const {
  const double range = extent_.highest_rad - extent_.lowest_rad;
  const double height = range > 0.0 ? (elevation_rad - extent_.lowest_rad) / range : 0.0;
  const int row = static_cast<int>(std::lround(std::clamp(height, 0.0, 1.0) * (kRows - 1)));
  return {columnsFrom(azimuth_rad), row};
}

void RoomLook::declare(Parameters& params) {
  constexpr double kBrightest = 1000.0;  // full wells
  params.number("surroundings/brightness", brightness, 0.0, kBrightest);
  params.number("surroundings/contrast", contrast, 0.0, 1.0);
}

RadianceFunction roomRadiance(const RoomLook& look) {
  constexpr int kHarmonics = 6;       // the finest structure is 60 degrees wide
  constexpr double kFloorPart = 0.6;  // floor and ceiling against the walls
  constexpr double kCeilingPart = 1.5;
  constexpr double kEdgeWidth_rad = 0.1;  // of the soft change between them
  struct Wave {
    double amplitude;
    double phase_rad;
  };
  RandomStream random(look.seed, RandomStream::Purpose::kImage);
  std::vector<Wave> waves;
  for (int i = 0; i < kHarmonics; ++i) {
    waves.push_back({random.uniform() / kHarmonics, 2.0 * kPi * random.uniform()});
  }
  return [look, waves](double azimuth_rad, double elevation_rad) {
    double wall = 1.0;
    for (std::size_t i = 0; i < waves.size(); ++i) {
      wall += look.contrast * waves[i].amplitude *
              std::sin(static_cast<double>(i + 1) * azimuth_rad + waves[i].phase_rad);
    }
    const double height = 0.5 * (1.0 + std::tanh(elevation_rad / kEdgeWidth_rad));
    return look.brightness * wall * (kFloorPart + (kCeilingPart - kFloorPart) * height);
  };
}

}  // namespace bearing_calibration::core
