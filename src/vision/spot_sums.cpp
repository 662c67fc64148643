#include "bearing_calibration/vision/spot_sums.h"

namespace bearing_calibration {
namespace {

Eigen::Matrix2d symmetric(float uu, float uv, float vv) {
  return (Eigen::Matrix2d() << uu, uv, uv, vv).finished();
}

WindowMetric metricOf(const SpotPatch& patch, const PixelEllipse& ellipse) {
  const Eigen::Matrix2d& information = ellipse.shape.information;
  const Eigen::Vector2d centre = patch.fromImage(ellipse.centre_px);
  return {static_cast<float>(-centre.x()), static_cast<float>(-centre.y()),
          static_cast<float>(information(0, 0)), static_cast<float>(2.0 * information(0, 1)),
          static_cast<float>(information(1, 1))};
}

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

PlaneSums sumPlane(const SpotPatch& patch, const RowSpans& ring, int row_step,
                   const PixelEllipse& ellipse, double threshold, double reference) {
  const RingSums s =
      pixelKernels().sumRing(patch.levels(), ring, row_step, metricOf(patch, ellipse),
                             static_cast<float>(threshold), static_cast<float>(reference));
  PlaneSums sums;
  sums.normal << s.n, s.u, s.v, s.u, s.uu, s.uv, s.v, s.uv, s.vv;
  sums.right << s.level, s.level_u, s.level_v;
  sums.squares = static_cast<double>(s.level2);
  return sums;
}

CentreMoments sumCentre(const SpotPatch& patch, const RowSpans& window, int row_step,
                        const PixelEllipse& ellipse, const WeightPolynomial& weight,
                        const LevelPlane& background) {
  const CentreSums s =
      pixelKernels().sumCentre(patch.levels(), window, row_step, metricOf(patch, ellipse),
                               termsOf(background), termsOf(weight));
  CentreMoments sums;
  sums.light = static_cast<double>(s.light);
  sums.weighted = static_cast<double>(s.weighted);
  sums.moment << s.moment_u, s.moment_v;
  sums.sloped_squares = symmetric(s.sloped_uu, s.sloped_uv, s.sloped_vv);
  return sums;
}

SpreadMoments sumSpread(const SpotPatch& patch, const SpotPatch& sensed, const RowSpans& window,
                        int row_step, const PixelEllipse& ellipse, const WeightPolynomial& weight,
                        const LevelPlane& background, const LevelNoise& noise) {
  const SpreadSums s = pixelKernels().sumSpread(patch.levels(), sensed.levels(), window, row_step,
                                                metricOf(patch, ellipse), termsOf(background),
                                                termsOf(weight), termsOf(noise));
  SpreadMoments sums;
  sums.light = static_cast<double>(s.light);
  sums.light_squares = symmetric(s.light_uu, s.light_uv, s.light_vv);
  sums.noise_squares = symmetric(s.noise_uu, s.noise_uv, s.noise_vv);
  sums.fourth_powers = static_cast<double>(s.fourth_powers);
  sums.peak = static_cast<double>(s.peak);
  sums.full_pixels = s.full_pixels;
  return sums;
}

}  // namespace bearing_calibration
