#include "bearing_calibration/vision/spot_sums.h"

#include "bearing_calibration/vision/image_levels.h"

namespace bearing_calibration::core {
namespace {

Eigen::Matrix2d symmetric(float uu, float uv, float vv) {
  return (Eigen::Matrix2d() << uu, uv, uv, vv).finished();
}

EllipseMetric metricOf(const PixelEllipse& ellipse) {
  const Eigen::Matrix2d& information = ellipse.shape.information;
  const int column = static_cast<int>(ellipse.centre_px.x());
  const int row = static_cast<int>(ellipse.centre_px.y());
  return {column,
          row,
          static_cast<float>(ellipse.centre_px.x() - column),
          static_cast<float>(ellipse.centre_px.y() - row),
          static_cast<float>(information(0, 0)),
          static_cast<float>(2.0 * information(0, 1)),
          static_cast<float>(information(1, 1))};
}

PixelRange rangeOf(const PixelEllipse& ellipse, const cv::Mat& image, int row_step) {
  const PixelBox box = ellipse.box(image.size());
  return {box.first_row, box.last_row, row_step, box.first_column, box.last_column};
}

template <typename Level>
ImageRows<Level> rowsLike(const ImageRows<Level>&, const cv::Mat& image) {
  return rowsOf<Level>(image);
}

float squared(double value) { return static_cast<float>(value * value); }

PlaneTerms termsOf(const LevelPlane& plane) {
  return {static_cast<float>(plane.at_centre), static_cast<float>(plane.slope.x()),
          static_cast<float>(plane.slope.y())};
}

WeightTerms termsOf(const WeightPolynomial& weight) {
  return {static_cast<float>(weight.constant), static_cast<float>(weight.square),
          static_cast<float>(weight.sixth)};
}

NoiseTerms termsOf(const LevelNoise& noise) {
  return {static_cast<float>(noise.black), static_cast<float>(noise.saturation),
          static_cast<float>(noise.per_level), static_cast<float>(noise.per_square)};
}

}  // namespace

PlaneSums sumPlane(const cv::Mat& image, const PixelEllipse& inner, double outer_reach,
                   int row_step, double threshold, double reference) {
  const PixelRange range = rangeOf(inner.reaching(outer_reach), image, row_step);
  const RingSums s = visitLevels(image, [&](const auto& levels, const auto& kernels) {
    return kernels.sumRing(levels, range, metricOf(inner), squared(inner.reach),
                           squared(outer_reach), static_cast<float>(threshold),
                           static_cast<float>(reference));
  });
  PlaneSums sums;
  sums.normal << s.n, s.u, s.v, s.u, s.uu, s.uv, s.v, s.uv, s.vv;
  sums.right << s.level, s.level_u, s.level_v;
  sums.squares = static_cast<double>(s.level2);
  return sums;
}

CentreMoments sumCentre(const cv::Mat& image, const PixelEllipse& window, int row_step,
                        const WeightPolynomial& weight, const LevelPlane& background) {
  const PixelRange range = rangeOf(window, image, row_step);
  const CentreSums s = visitLevels(image, [&](const auto& levels, const auto& kernels) {
    return kernels.sumCentre(levels, range, metricOf(window), squared(window.reach),
                             termsOf(background), termsOf(weight));
  });
  CentreMoments sums;
  sums.light = static_cast<double>(s.light);
  sums.weighted = static_cast<double>(s.weighted);
  sums.moment << s.moment_u, s.moment_v;
  sums.sloped_squares = symmetric(s.sloped_uu, s.sloped_uv, s.sloped_vv);
  return sums;
}

SpreadMoments sumSpread(const cv::Mat& image, const cv::Mat& sensed, const PixelEllipse& window,
                        int row_step, const WeightPolynomial& weight, const LevelPlane& background,
                        const LevelNoise& noise) {
  const PixelRange range = rangeOf(window, image, row_step);
  const SpreadSums s = visitLevels(image, [&](const auto& levels, const auto& kernels) {
    return kernels.sumSpread(levels, rowsLike(levels, sensed), range, metricOf(window),
                             squared(window.reach), termsOf(background), termsOf(weight),
                             termsOf(noise));
  });
  SpreadMoments sums;
  sums.light = static_cast<double>(s.light);
  sums.light_squares = symmetric(s.light_uu, s.light_uv, s.light_vv);
  sums.noise_squares = symmetric(s.noise_uu, s.noise_uv, s.noise_vv);
  sums.fourth_powers = static_cast<double>(s.fourth_powers);
  sums.peak = static_cast<double>(s.peak);
  sums.full_pixels = s.full_pixels;
  return sums;
}

}  // namespace bearing_calibration::core
