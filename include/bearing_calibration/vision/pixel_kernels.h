#pragma once

#include <cstddef>
#include <cstdint>

#include "bearing_calibration/vision/pixel_interval.h"

/// The loops that are most of a detection's time, as a table of functions: compiled once for every
/// processor and once for those with AVX2 and FMA. Plain numbers go in and out, and only plain
/// structs are included, so that no inline function of another header is compiled for one processor
/// alone.
namespace bearing_calibration {

/// An image's levels, row by row.
template <typename Level>
struct ImageRows {
  const Level* levels = nullptr;
  std::ptrdiff_t stride = 0;  ///< in levels
  int columns = 0;
};

/// Room for the runs of bright pixels: of the intervals which have some (or bright pixels shortly
/// beside them), their places in a list and where their runs' edges end; the edges are columns,
/// where a run begins and where it ends in turn.
struct BrightRuns {
  std::size_t* intervals = nullptr;  ///< room for one more than there are intervals
  int* ends = nullptr;
  int* edges = nullptr;
  std::size_t room = 0;  ///< for edges: those of a whole row at least
};
struct BrightCount {
  std::size_t intervals;
  bool complete;  ///< false when there was no room for all
};

/// Pixels [begin[i], end[i]) of the rows from first_row on, in coordinates of a patch; of the
/// second piece [begin[room + i], end[room + i]), and so on.
struct RowSpans {
  int first_row = 0;
  int rows = 0;
  int room = 0;  ///< rows up to whole lanes
  int pieces = 1;
  const int* begin = nullptr;
  const int* end = nullptr;
};

/// Levels as numbers, row by row. A loop may read up to kPixelLanes - 1 levels beyond a row's end.
struct LevelRows {
  const float* levels = nullptr;
  int stride = 0;
};
constexpr int kPixelLanes = 8;

/// An ellipse by the chords that it cuts from rows: at the height v over its centre the squared
/// half length half2 - narrowing v^2 and the middle at centre_u + skew v.
struct EllipseChords {
  float centre_u;  ///< in coordinates of a patch, as all here
  float centre_v;
  float skew;
  float narrowing;
  float half2;
};

/// Where a window's centre is counted from, and its Mahalanobis distance uu u^2 + uv u v + vv v^2.
struct WindowMetric {
  float u0;  ///< of the patch's first pixel from the centre
  float v0;
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

/// As in WindowSums.
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

struct PixelKernels {
  /// Finds the runs of pixels above the threshold in `count` intervals.
  BrightCount (*findRunsOfBytes)(const ImageRows<std::uint8_t>& image,
                                 const PixelInterval* intervals, std::size_t count, int threshold,
                                 const BrightRuns& runs);
  BrightCount (*findRunsOfWords)(const ImageRows<std::uint16_t>& image,
                                 const PixelInterval* intervals, std::size_t count, int threshold,
                                 const BrightRuns& runs);
  /// Copies an image's first rows as numbers.
  void (*copyBytes)(const ImageRows<std::uint8_t>& image, int rows, float* levels, int stride);
  void (*copyWords)(const ImageRows<std::uint16_t>& image, int rows, float* levels, int stride);
  /// The pixels of an ellipse in `rows` rows, not beyond [0, columns); has room for
  /// whole lanes of chords.
  void (*cutChords)(const EllipseChords& ellipse, int first_row, int rows, int columns, int* begin,
                    int* end);
  // The sums take every row_step-th row.
  RingSums (*sumRing)(const LevelRows& patch, const RowSpans& spans, int row_step,
                      const WindowMetric& metric, float threshold, float reference);
  CentreSums (*sumCentre)(const LevelRows& patch, const RowSpans& spans, int row_step,
                          const WindowMetric& metric, const PlaneTerms& plane,
                          const WeightTerms& weight);
  /// @param sensed the same levels before any software defocus
  SpreadSums (*sumSpread)(const LevelRows& patch, const LevelRows& sensed, const RowSpans& spans,
                          int row_step, const WindowMetric& metric, const PlaneTerms& plane,
                          const WeightTerms& weight, const NoiseTerms& noise);
};

/// The fastest that the processor at hand can run.
const PixelKernels& pixelKernels();

/// Those that every processor can run, for tests.
const PixelKernels& portablePixelKernels();

}  // namespace bearing_calibration
