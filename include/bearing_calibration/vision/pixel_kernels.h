#pragma once

#include <cstddef>
#include <cstdint>

#include "bearing_calibration/vision/pixel_strip.h"

/// The loops that are most of a detection's time, as a table of functions: compiled once for every
/// processor and once for those with AVX2 and FMA. Plain numbers go in and out, and only plain
/// structs are included, so that no inline function of another header is compiled for one processor
/// alone.
namespace bearing_calibration::core {

/// An image's levels, row by row.
template <typename Level>
struct ImageRows {
  const Level* levels = nullptr;
  std::ptrdiff_t stride = 0;  ///< in levels
  int columns = 0;
};

/// A strip's row which has bright pixels, or some shortly beside it.
struct BrightRow {
  int row;
  int begin;
  int end;
  int edges;  ///< of this row's runs and of those before
};

/// Room for the runs of bright pixels. The edges are columns, where a run begins and where it ends
/// in turn.
struct BrightRuns {
  BrightRow* rows = nullptr;  ///< room for all that the strips have
  int* edges = nullptr;
  std::size_t room = 0;  ///< for edges: those of a whole row at least
};
struct BrightCount {
  std::size_t rows;
  bool complete;  ///< false when there was no room for all
};

constexpr int kPixelLanes = 8;  ///< pixels that a loop takes side by side

/// The pixels of an image that a sum looks at: every row_step-th row of a box in it.
struct PixelRange {
  int first_row;
  int last_row;
  int row_step;
  int first_column;
  int last_column;
};

/// An ellipse: a centre and the squared Mahalanobis distance uu u^2 + uv u v + vv v^2 from there.
struct EllipseMetric {
  int column;  ///< of a pixel near the centre, which lies so far beyond it:
  int row;
  float beyond_u;
  float beyond_v;
  float uu;
  float uv;
  float vv;
};

/// Levels of a background: at_centre + slope_u u + slope_v v.
struct PlaneTerms {
  float at_centre;
  float slope_u;
  float slope_v;
};

/// Weights constant + m^2 (square + sixth m^4).
struct WeightTerms {
  float constant;
  float square;
  float sixth;
};

/// As LevelNoise.
struct NoiseTerms {
  float black;
  float saturation;
  float per_level;
  float per_square;
};

/// Over pixels that are not brighter than a threshold, of levels less a reference.
struct RingSums {
  float n, u, v, uu, uv, vv;
  float level, level_u, level_v, level2;
};

/// As in CentreMoments and SpreadMoments.
struct CentreSums {
  float light, weighted, moment_u, moment_v;
  float sloped_uu, sloped_uv, sloped_vv;
};
struct SpreadSums {
  float light;
  float light_uu, light_uv, light_vv;
  float noise_uu, noise_uv, noise_vv;
  float fourth_powers, peak;
  int full_pixels;
};

/// The loops over levels of one type. The sums take images of kPixelLanes columns at least.
template <typename Level>
struct LevelKernels {
  /// Finds the runs of pixels above the threshold in `count` strips.
  BrightCount (*findRuns)(const ImageRows<Level>& image, const PixelStrip* strips,
                          std::size_t count, int threshold, const BrightRuns& runs);
  /// Over the pixels between two ellipses, of squared Mahalanobis distances in (inner2, outer2].
  RingSums (*sumRing)(const ImageRows<Level>& image, const PixelRange& range,
                      const EllipseMetric& metric, float inner2, float outer2, float threshold,
                      float reference);
  /// Over an ellipse's pixels, of squared Mahalanobis distances up to reach2.
  CentreSums (*sumCentre)(const ImageRows<Level>& image, const PixelRange& range,
                          const EllipseMetric& metric, float reach2, const PlaneTerms& plane,
                          const WeightTerms& weight);
  /// @param sensed the same image before any software defocus
  SpreadSums (*sumSpread)(const ImageRows<Level>& image, const ImageRows<Level>& sensed,
                          const PixelRange& range, const EllipseMetric& metric, float reach2,
                          const PlaneTerms& plane, const WeightTerms& weight,
                          const NoiseTerms& noise);
};

struct PixelKernels {
  LevelKernels<std::uint8_t> bytes;
  LevelKernels<std::uint16_t> words;
};

/// The fastest that the processor at hand can run.
const PixelKernels& pixelKernels();

/// Those that every processor can run, for tests.
const PixelKernels& portablePixelKernels();

}  // namespace bearing_calibration::core
