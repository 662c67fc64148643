#include "bearing_calibration/simulation/panorama.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/random_stream.h"

namespace bearing_calibration::core {
namespace {

constexpr double kRadiansPerColumn = 2.0 * kPi / Panorama::kColumns;

/// Weights of a Gaussian blur at -n .. n cells, with sum 1.
std::vector<double> blurWeights(double stddev_cells) {
  constexpr double kReach = 3.0;  // standard deviations; 0.3 % of the weight lies beyond
  const int n = static_cast<int>(std::ceil(kReach * stddev_cells));
  std::vector<double> weights(static_cast<std::size_t>(2 * n + 1), 1.0);
  double sum = 0.0;
  for (int i = -n; n > 0 && i <= n; ++i) {
    const double distance = i / stddev_cells;
    weights[static_cast<std::size_t>(i + n)] = std::exp(-0.5 * distance * distance);
  }
  for (double weight : weights) sum += weight;
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// `value(place)` blurred along one axis, at `place`.
template <typename Value>
double blurred(const std::vector<double>& weights, int place, const Value& value) {
  const int n = static_cast<int>(weights.size()) / 2;
  double sum = 0.0;
  for (int i = -n; i <= n; ++i) sum += weights[static_cast<std::size_t>(i + n)] * value(place + i);
  return sum;
}

}  // namespace

Panorama::Panorama(const RadianceFunction& radiance, const Extent& extent) : extent_(extent) {
  const double radians_per_row = (extent.highest_rad - extent.lowest_rad) / (kRows - 1);
  const auto column_weights = blurWeights(extent.azimuth_blur_rad / kRadiansPerColumn);
  const auto row_weights =
      blurWeights(radians_per_row > 0.0 ? extent.elevation_blur_rad / radians_per_row : 0.0);
  table_.resize(static_cast<std::size_t>(kRows * kStride));
  // Rows beyond the table's edge count in the blur of its rows.
  const int margin = static_cast<int>(row_weights.size()) / 2;
  std::vector<std::vector<double>> rows(static_cast<std::size_t>(kRows + 2 * margin),
                                        std::vector<double>(kColumns));
  std::vector<double> sharp(kColumns);
  for (int row = -margin; row < kRows + margin; ++row) {
    const double elevation = extent.lowest_rad + row * radians_per_row;
    for (int column = 0; column < kColumns; ++column) {
      sharp[static_cast<std::size_t>(column)] = radiance(column * kRadiansPerColumn, elevation);
    }
    for (int column = 0; column < kColumns; ++column) {
      rows[static_cast<std::size_t>(row + margin)][static_cast<std::size_t>(column)] =
          blurred(column_weights, column, [&sharp](int place) {
            return sharp[static_cast<std::size_t>((place + kColumns) % kColumns)];
          });
    }
  }
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kStride; ++column) {
      table_[static_cast<std::size_t>(row * kStride + column)] =
          static_cast<float>(blurred(row_weights, row + margin, [&](int place) {
            return rows[static_cast<std::size_t>(place)]
                       [static_cast<std::size_t>(column % kColumns)];
          }));
    }
  }
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
