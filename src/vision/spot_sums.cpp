#include "bearing_calibration/vision/spot_sums.h"

#include <Eigen/LU>
#include <algorithm>

#include "bearing_calibration/vision/processor_clones.h"

namespace bearing_calibration {
namespace {

/// A window's ellipse, weights and background in the loops' numbers.
struct WindowTerms {
  WindowTerms(const PixelEllipse& ellipse, const WeightPolynomial& polynomial,
              const LevelPlane& background) {
    const Eigen::Matrix2d information = ellipse.covariance_px2.inverse();
    centre_u = static_cast<float>(ellipse.centre_px.x());
    centre_v = static_cast<float>(ellipse.centre_px.y());
    uu = static_cast<float>(information(0, 0));
    uv = static_cast<float>(2.0 * information(0, 1));
    vv = static_cast<float>(information(1, 1));
    reach2 = static_cast<float>(ellipse.reach * ellipse.reach);
    constant = static_cast<float>(polynomial.constant);
    square = static_cast<float>(polynomial.square);
    sixth = static_cast<float>(polynomial.sixth);
    at_centre = static_cast<float>(background.at_centre);
    slope_u = static_cast<float>(background.slope.x());
    slope_v = static_cast<float>(background.slope.y());
  }

  float centre_u, centre_v;
  float uu, uv, vv, reach2;
  float constant, square, sixth;
  float at_centre, slope_u, slope_v;
};

Eigen::Matrix2d symmetric(float uu, float uv, float vv) {
  return (Eigen::Matrix2d() << uu, uv, uv, vv).finished();
}

struct NoiseTerms {
  explicit NoiseTerms(const LevelNoise& noise)
      : black(static_cast<float>(noise.black)),
        saturation(static_cast<float>(noise.saturation)),
        per_level(static_cast<float>(noise.per_level)),
        per_square(static_cast<float>(noise.per_square)) {}

  float black, saturation, per_level, per_square;
};

/// All sums in one loop; the centre's alone with `kCentreOnly`, for which the compiler leaves the
/// others out.
template <bool kCentreOnly>
inline __attribute__((always_inline)) WindowSums sumUp(const PixelColumn& pixels,
                                                       const float* sensed, const WindowTerms& t,
                                                       const NoiseTerms& noise) {
  const float* levels = pixels.levels.data();
  const float* us = pixels.u_px.data();
  const float* vs = pixels.v_px.data();
  float light = 0, weighted = 0, moment_u = 0, moment_v = 0, sloped_uu = 0, sloped_uv = 0,
        sloped_vv = 0, light_uu = 0, light_uv = 0, light_vv = 0, noise_uu = 0, noise_uv = 0,
        noise_vv = 0, fourth_powers = 0, full = 0, peak = 0;
#pragma omp simd reduction(+ : light, weighted, moment_u, moment_v, sloped_uu, sloped_uv,         \
                               sloped_vv, light_uu, light_uv, light_vv, noise_uu, noise_uv,       \
                               noise_vv, fourth_powers, full) reduction(max : peak)
  for (int i = 0; i < pixels.size; ++i) {
    const float u = us[i] - t.centre_u;
    const float v = vs[i] - t.centre_v;
    const float m2 = t.uu * u * u + t.uv * u * v + t.vv * v * v;
    const float m4 = m2 * m2;
    const float one = m2 <= t.reach2 ? 1.0F : 0.0F;
    const float over = one * (levels[i] - t.at_centre - t.slope_u * u - t.slope_v * v);
    const float weight = t.constant + m2 * (t.square + t.sixth * m4);
    const float sloped = over * (t.square + 3.0F * t.sixth * m4);
    light += over;
    weighted += over * weight;
    moment_u += over * weight * u;
    moment_v += over * weight * v;
    sloped_uu += sloped * u * u;
    sloped_uv += sloped * u * v;
    sloped_vv += sloped * v * v;
    if (kCentreOnly) continue;
    const float is_full = sensed[i] >= noise.saturation ? one : 0.0F;
    const float photons = (one - is_full) * std::max(0.0F, levels[i] - noise.black);
    const float variance = noise.per_level * photons + noise.per_square * over * over;
    const float noisy = variance * weight * weight;
    light_uu += over * u * u;
    light_uv += over * u * v;
    light_vv += over * v * v;
    noise_uu += noisy * u * u;
    noise_uv += noisy * u * v;
    noise_vv += noisy * v * v;
    fourth_powers += over * m4;
    full += is_full;
    peak = std::max(peak, one * levels[i]);
  }
  WindowSums sums;
  sums.light = static_cast<double>(light);
  sums.weighted = static_cast<double>(weighted);
  sums.moment << moment_u, moment_v;
  sums.sloped_squares = symmetric(sloped_uu, sloped_uv, sloped_vv);
  sums.light_squares = symmetric(light_uu, light_uv, light_vv);
  sums.noise_squares = symmetric(noise_uu, noise_uv, noise_vv);
  sums.fourth_powers = static_cast<double>(fourth_powers);
  sums.peak = static_cast<double>(peak);
  sums.full_pixels = static_cast<int>(full);
  return sums;
}

}  // namespace

BEARING_CALIBRATION_CLONES PlaneSums sumPlane(const PixelColumn& pixels, double threshold,
                                              double reference) {
  const float most = static_cast<float>(threshold);
  const float zero = static_cast<float>(reference);
  const float* levels = pixels.levels.data();
  const float* us = pixels.u_px.data();
  const float* vs = pixels.v_px.data();
  float n = 0, n_u = 0, n_v = 0, n_uu = 0, n_uv = 0, n_vv = 0, lit = 0, lit_u = 0, lit_v = 0,
        lit2 = 0;
#pragma omp simd reduction(+ : n, n_u, n_v, n_uu, n_uv, n_vv, lit, lit_u, lit_v, lit2)
  for (int i = 0; i < pixels.size; ++i) {
    const float one = levels[i] <= most ? 1.0F : 0.0F;
    const float u = one * us[i];
    const float v = one * vs[i];
    const float level = one * (levels[i] - zero);
    n += one;
    n_u += u;
    n_v += v;
    n_uu += u * u;
    n_uv += u * v;
    n_vv += v * v;
    lit += level;
    lit_u += level * u;
    lit_v += level * v;
    lit2 += level * level;
  }
  PlaneSums sums;
  sums.normal << n, n_u, n_v, n_u, n_uu, n_uv, n_v, n_uv, n_vv;
  sums.right << lit, lit_u, lit_v;
  sums.squares = static_cast<double>(lit2);
  return sums;
}

BEARING_CALIBRATION_CLONES WindowSums sumCentre(const PixelColumn& pixels,
                                                const PixelEllipse& ellipse,
                                                const WeightPolynomial& weight,
                                                const LevelPlane& background) {
  constexpr bool kCentreOnly = true;
  return sumUp<kCentreOnly>(pixels, nullptr, WindowTerms(ellipse, weight, background),
                            NoiseTerms({}));
}

BEARING_CALIBRATION_CLONES WindowSums
sumWindow(const PixelColumn& pixels, const std::vector<float>& sensed, const PixelEllipse& ellipse,
          const WeightPolynomial& weight, const LevelPlane& background, const LevelNoise& noise) {
  constexpr bool kCentreOnly = false;
  return sumUp<kCentreOnly>(pixels, sensed.data(), WindowTerms(ellipse, weight, background),
                            NoiseTerms(noise));
}

}  // namespace bearing_calibration
