#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>

#include "bearing_calibration/vision/spot_meter.h"

namespace bearing_calibration::core {
namespace {

// A loop over lanes has no branches and a length that the compiler knows: it becomes vector
// instructions of whatever width there is.
using Lanes = std::array<float, kPixelLanes>;

/// Pixels side by side in a row.
struct PixelBlock {
  int row;
  int column;  ///< of the first
  float v;     ///< from the ellipse's centre
  Lanes u;
  Lanes m2;  ///< squared Mahalanobis distance
  Lanes level;
};

double sumOf(const Lanes& lanes) { return std::accumulate(lanes.begin(), lanes.end(), 0.0); }

/// Three sums of the pixels.
struct Sums {
  void add(std::size_t lane, float a, float b, float c) {
    first[lane] += a;
    second[lane] += b;
    third[lane] += c;
  }
  Eigen::Vector3d vector() const { return {sumOf(first), sumOf(second), sumOf(third)}; }
  /// Of sums over (uu, uv, vv).
  Eigen::Matrix2d matrix() const {
    const Eigen::Vector3d sums = vector();
    return (Eigen::Matrix2d() << sums(0), sums(1), sums(1), sums(2)).finished();
  }

  Lanes first{}, second{}, third{};
};

Lanes levelsAt(const cv::Mat& image, int row, int column) {
  Lanes levels;
  if (image.depth() == CV_8U) {
    std::copy_n(image.ptr<std::uint8_t>(row) + column, kPixelLanes, levels.begin());
  } else {
    std::copy_n(image.ptr<std::uint16_t>(row) + column, kPixelLanes, levels.begin());
  }
  return levels;
}

/// The smallest box with all pixels of an ellipse that an image of this size has.
cv::Rect boxOf(const PixelEllipse& ellipse, const cv::Size& image) {
  const Eigen::Vector2d reach = ellipse.size * ellipse.covariance_px2.diagonal().cwiseSqrt();
  const auto first_after = [](double place, int last) {
    return static_cast<int>(std::clamp(place + 1.0, 0.0, static_cast<double>(last)));
  };
  const Eigen::Vector2d low = ellipse.centre_px - reach;
  const Eigen::Vector2d high = ellipse.centre_px + reach;
  return {cv::Point(first_after(low.x(), image.width), first_after(low.y(), image.height)),
          cv::Point(first_after(high.x(), image.width), first_after(high.y(), image.height))};
}

float squared(double value) { return static_cast<float>(value * value); }

/// A factor instead of a branch.
float oneIf(bool condition) { return condition ? 1.0F : 0.0F; }

/// Visits the pixels of an ellipse, none twice, and others that lie outside of it.
template <typename Visit>
void forEachBlock(const cv::Mat& image, const PixelEllipse& ellipse, int row_step, Visit visit) {
  constexpr float kFarOutside = 1e6F;  // whose cube still is a number
  const Eigen::Matrix2f information = ellipse.covariance_px2.inverse().cast<float>();
  const float uu = information(0, 0);
  const float uv = 2.0F * information(0, 1);
  const float vv = information(1, 1);

  const cv::Rect box = boxOf(ellipse, image.size());
  PixelBlock block;
  for (block.row = box.y; block.row < box.br().y; block.row += row_step) {
    const float v = static_cast<float>(block.row - ellipse.centre_px.y());
    block.v = v;
    for (int column = box.x; column < box.br().x; column += kPixelLanes) {
      block.column = std::min(column, image.cols - kPixelLanes);  // not beyond the row
      const int visited = column - block.column;
      const float first_u = static_cast<float>(block.column - ellipse.centre_px.x());
      block.level = levelsAt(image, block.row, block.column);
      for (int i = 0; i < kPixelLanes; ++i) {
        const std::size_t lane = static_cast<std::size_t>(i);
        const float u = first_u + static_cast<float>(i);
        const float m2 = uu * u * u + v * (uv * u + vv * v);
        block.u[lane] = u;
        block.m2[lane] = m2 + kFarOutside * oneIf(i < visited);
      }
      visit(block);
    }
  }
}

}  // namespace

PlaneSums sumPlane(const cv::Mat& image, const PixelEllipse& inner, double outer_size, int row_step,
                   double threshold, double reference) {
  const float inner2 = squared(inner.size);
  const float outer2 = squared(outer_size);
  const float limit = static_cast<float>(threshold);
  const float zero = static_cast<float>(reference);
  Sums pixels, spread, levels;
  Lanes squares{};
  forEachBlock(image, {inner.centre_px, inner.covariance_px2, outer_size}, row_step,
               [&](const PixelBlock& block) {
                 const float v = block.v;
                 for (std::size_t i = 0; i < kPixelLanes; ++i) {
                   const float u = block.u[i];
                   const float m2 = block.m2[i];
                   const float dark =
                       oneIf(m2 > inner2) * oneIf(m2 <= outer2) * oneIf(block.level[i] <= limit);
                   const float level = dark * (block.level[i] - zero);
                   pixels.add(i, dark, dark * u, dark * v);
                   spread.add(i, dark * u * u, dark * u * v, dark * v * v);
                   levels.add(i, level, level * u, level * v);
                   squares[i] += level * level;
                 }
               });
  const Eigen::Vector3d first = pixels.vector();
  PlaneSums sums;
  sums.normal << first.transpose(), first.tail<2>(), spread.matrix();
  sums.right = levels.vector();
  sums.squares = sumOf(squares);
  return sums;
}

CentreMoments sumCentre(const cv::Mat& image, const PixelEllipse& window, int row_step,
                        WeightPolynomial weight, const LevelPlane& background) {
  const float reach2 = squared(window.size);
  Lanes light{};
  Sums weighted, sloped;
  forEachBlock(image, window, row_step, [&](const PixelBlock& block) {
    const float v = block.v;
    for (std::size_t i = 0; i < kPixelLanes; ++i) {
      const float u = block.u[i];
      const float m2 = block.m2[i];
      const float over = oneIf(m2 <= reach2) * (block.level[i] - background.at(u, v));
      const float by_weight = over * weight.at(m2);
      const float by_slope = over * weight.slope(m2);
      light[i] += over;
      weighted.add(i, by_weight, by_weight * u, by_weight * v);
      sloped.add(i, by_slope * u * u, by_slope * u * v, by_slope * v * v);
    }
  });
  const Eigen::Vector3d first = weighted.vector();
  return {sumOf(light), first(0), first.tail<2>(), sloped.matrix()};
}

SpreadMoments sumSpread(const cv::Mat& image, const cv::Mat& sensed, const PixelEllipse& window,
                        int row_step, WeightPolynomial weight, const LevelPlane& background,
                        const ImageSensor& sensor) {
  const float reach2 = squared(window.size);
  const float black = static_cast<float>(sensor.black_level);
  const float saturation = static_cast<float>(sensor.saturation_level);
  const float per_level = static_cast<float>(1.0 / sensor.electrons_per_level);
  const float per_square = squared(sensor.response_spread);
  Sums light_squares, noise_squares;
  Lanes light{}, fourth_powers{}, peak{}, full{};
  forEachBlock(image, window, row_step, [&](const PixelBlock& block) {
    const Lanes sensed_level = levelsAt(sensed, block.row, block.column);
    const float v = block.v;
    for (std::size_t i = 0; i < kPixelLanes; ++i) {
      const float u = block.u[i];
      const float m2 = block.m2[i];
      const float inside = oneIf(m2 <= reach2);
      const float level = inside * block.level[i];
      const float over = inside * (block.level[i] - background.at(u, v));
      const float is_full = inside * oneIf(sensed_level[i] >= saturation);
      const float photons = (1.0F - is_full) * oneIf(level > black) * (level - black);
      const float by_weight = weight.at(m2);
      const float noise = (per_level * photons + per_square * over * over) * by_weight * by_weight;
      light[i] += over;
      light_squares.add(i, over * u * u, over * u * v, over * v * v);
      noise_squares.add(i, noise * u * u, noise * u * v, noise * v * v);
      fourth_powers[i] += over * (m2 * m2);
      peak[i] = peak[i] < level ? level : peak[i];
      full[i] += is_full;
    }
  });
  return {sumOf(light),
          light_squares.matrix(),
          noise_squares.matrix(),
          sumOf(fourth_powers),
          static_cast<double>(*std::max_element(peak.begin(), peak.end())),
          static_cast<int>(sumOf(full))};
}

}  // namespace bearing_calibration::core
