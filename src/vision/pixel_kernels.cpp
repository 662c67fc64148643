// Compiled several times, with BEARING_CALIBRATION_KERNELS as the table's name.

#include "bearing_calibration/vision/pixel_kernels.h"

#include <cstring>
#include <type_traits>
#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace bearing_calibration::core {

extern const PixelKernels BEARING_CALIBRATION_KERNELS;

namespace {

constexpr int kBytes = kPixelLanes * static_cast<int>(sizeof(float));
using Lanes = float __attribute__((vector_size(kBytes)));
using IntLanes = std::int32_t __attribute__((vector_size(kBytes)));
using ByteLanes = std::uint8_t __attribute__((vector_size(kBytes)));
using WordLanes = std::uint16_t __attribute__((vector_size(kBytes)));

constexpr IntLanes kLane = {0, 1, 2, 3, 4, 5, 6, 7};

/// Zero where `inside` is not set.
inline void keep(const IntLanes& inside, Lanes* lanes) {
  *lanes = reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(*lanes) & inside);
}

inline float largestOf(const Lanes& lanes) {
  float largest = lanes[0];
  for (int i = 1; i < kPixelLanes; ++i) largest = largest < lanes[i] ? lanes[i] : largest;
  return largest;
}

template <typename Level>
inline const Level* rowOf(const ImageRows<Level>& image, int v) {
  return image.levels + v * image.stride;
}

#ifdef __AVX2__
// An instruction or two each, which compilers do not find by themselves.
inline void sumLanes(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, float* sums) {
  const __m256 of_quarters = _mm256_hadd_ps(_mm256_hadd_ps(a, b), _mm256_hadd_ps(c, d));
  const __m128 low = _mm256_castps256_ps128(of_quarters);
  _mm_storeu_ps(sums, _mm_add_ps(low, _mm256_extractf128_ps(of_quarters, 1)));
}
inline bool isZero(const IntLanes& lanes) {
  const __m256i all = reinterpret_cast<__m256i>(lanes);
  return _mm256_testz_si256(all, all) != 0;
}
inline void widen(const std::uint8_t* levels, IntLanes* wide) {
  std::int64_t bytes = 0;
  std::memcpy(&bytes, levels, sizeof(bytes));
  *wide = reinterpret_cast<IntLanes>(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bytes)));
}
inline void widen(const std::uint16_t* levels, IntLanes* wide) {
  __m128i words;
  std::memcpy(&words, levels, sizeof(words));
  *wide = reinterpret_cast<IntLanes>(_mm256_cvtepu16_epi32(words));
}
/// A bit for each of 32 levels, set where it is above the limit.
inline std::uint32_t brightBits32(const std::uint8_t* levels, const ByteLanes& limit) {
  ByteLanes block;
  std::memcpy(&block, levels, kBytes);
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(reinterpret_cast<__m256i>(block > limit)));
}
inline std::uint32_t brightBits32(const std::uint16_t* levels, const WordLanes& limit) {
  WordLanes first;
  WordLanes second;
  std::memcpy(&first, levels, kBytes);
  std::memcpy(&second, levels + kBytes / sizeof(*levels), kBytes);
  const __m256i mixed = _mm256_packs_epi16(reinterpret_cast<__m256i>(first > limit),
                                           reinterpret_cast<__m256i>(second > limit));
  constexpr int kInOrder = 0xD8;
  return static_cast<std::uint32_t>(
      _mm256_movemask_epi8(_mm256_permute4x64_epi64(mixed, kInOrder)));
}
#else
inline void sumLanes(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, float* sums) {
  for (int i = 0; i < 4; ++i) sums[i] = 0.0F;
  for (int i = 0; i < kPixelLanes; ++i) {
    sums[0] += a[i];
    sums[1] += b[i];
    sums[2] += c[i];
    sums[3] += d[i];
  }
}
inline bool isZero(const IntLanes& lanes) {
  std::int32_t any = 0;
  for (int i = 0; i < kPixelLanes; ++i) any |= lanes[i];
  return any == 0;
}
template <typename Level>
inline void widen(const Level* levels, IntLanes* wide) {
  for (int i = 0; i < kPixelLanes; ++i) (*wide)[i] = levels[i];
}
template <typename Level, typename Vector>
inline std::uint32_t brightBits32(const Level* levels, const Vector& limit) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < 32; ++i) bits |= (levels[i] > limit[0] ? 1U : 0U) << i;
  return bits;
}
#endif
constexpr unsigned kBitsPerBlock = 64;

template <typename Level, typename Vector>
inline void fill(int threshold, Vector* limit) {
  constexpr int kMost = static_cast<Level>(-1);
  const Level level = static_cast<Level>(threshold < kMost ? threshold : kMost);
  *limit = Vector{} + level;
}

/// Writes the strip's rows that have a level above the limit in these vectors from `begin` on.
/// @return behind the last of these. Mostly the scene is dark, and a row takes a dozen
/// instructions.
template <int count, typename Vector, typename Level>
inline BrightRow* findBrightRows(const ImageRows<Level>& image, const PixelStrip& strip, int begin,
                                 int vectors, const Vector& limit, BrightRow* found) {
  constexpr int kLevels = kBytes / static_cast<int>(sizeof(Level));
  if (count > 0) vectors = count;  // known to the compiler
  const Level* levels = rowOf(image, strip.row) + begin;
  BrightRow row{strip.row, strip.begin, strip.end, 0};
  for (const int end = strip.row + strip.rows; row.row < end; ++row.row) {
    Vector brightest = limit;
    for (int vector = 0; vector < vectors; ++vector) {
      Vector block;
      std::memcpy(&block, levels + vector * kLevels, kBytes);
      brightest = brightest < block ? block : brightest;
    }
    if (!isZero(reinterpret_cast<IntLanes>(brightest ^ limit))) *found++ = row;
    levels += image.stride;
  }
  return found;
}

/// The same of all strips, and how many these are; of an image narrower than a vector, all.
template <typename Vector, typename Level>
inline std::size_t findBright(const ImageRows<Level>& image, const PixelStrip* strips,
                              std::size_t count, const Vector& limit, BrightRow* found) {
  constexpr int kLevels = kBytes / static_cast<int>(sizeof(Level));
  const BrightRow* first_found = found;
  for (const PixelStrip* strip = strips; strip != strips + count; ++strip) {
    // In whole vectors, and not beyond the row.
    const unsigned pixels = static_cast<unsigned>(strip->end - strip->begin);
    const int vectors = static_cast<int>((pixels + kLevels - 1) / kLevels);
    const int last = image.columns - vectors * kLevels;
    const int begin = strip->begin < last ? strip->begin : last;
    if (begin < 0) {
      for (int row = 0; row < strip->rows; ++row) {
        *found++ = {strip->row + row, strip->begin, strip->end, 0};
      }
    } else if (vectors == 1) {
      found = findBrightRows<1>(image, *strip, begin, vectors, limit, found);
    } else if (vectors == 2) {
      found = findBrightRows<2>(image, *strip, begin, vectors, limit, found);
    } else {
      found = findBrightRows<0>(image, *strip, begin, vectors, limit, found);
    }
  }
  return static_cast<std::size_t>(found - first_found);
}

/// A bit for each of a block's levels, set where it is above the limit.
template <typename Vector, typename Level>
inline std::uint64_t brightBits(const Level* block, const Vector& limit) {
  return brightBits32(block, limit) | std::uint64_t{brightBits32(block + kBitsPerBlock / 2, limit)}
                                          << (kBitsPerBlock / 2);
}

/// The same for pixels [begin, end) of a row, 63 of them at most.
template <typename Vector, typename Level>
inline std::uint64_t brightPixels(const Level* row, int columns, int begin, int end,
                                  const Vector& limit) {
  constexpr int kBlock = kBitsPerBlock;
  std::uint64_t bits = 0;
  if (columns >= kBlock) {
    const int first = begin < columns - kBlock ? begin : columns - kBlock;  // not beyond the row
    bits = brightBits(row + first, limit) >> static_cast<unsigned>(begin - first);
  } else {
    Level block[kBlock] = {};
    for (int i = 0; i < end - begin; ++i) block[i] = row[begin + i];
    bits = brightBits(block, limit);
  }
  return bits & ((std::uint64_t{1} << static_cast<unsigned>(end - begin)) - 1);
}

/// Writes where runs begin and end, in turn: at changes from bit to bit. @return behind the last
inline int* writeEdges(std::uint64_t changes, int begin, int* edges) {
  for (; changes != 0; changes &= changes - 1) *edges++ = begin + __builtin_ctzll(changes);
  return edges;
}

/// The same of a row's part.
template <typename Vector, typename Level>
inline int* findEdges(const ImageRows<Level>& image, const BrightRow& part, const Vector& limit,
                      int* edges) {
  constexpr int kBlock = kBitsPerBlock;
  const Level* row = rowOf(image, part.row);
  std::uint64_t carry = 0;  // whether the pixel before is bright
  int begin = part.begin;
  for (; part.end - begin >= kBlock; begin += kBlock) {
    const std::uint64_t bits = brightBits(row + begin, limit);
    edges = writeEdges(bits ^ (bits << 1U | carry), begin, edges);
    carry = bits >> (kBitsPerBlock - 1U);
  }
  // The rest, and what follows, which is dark.
  const std::uint64_t bits =
      begin < part.end ? brightPixels(row, image.columns, begin, part.end, limit) : 0;
  return writeEdges(bits ^ (bits << 1U | carry), begin, edges);
}

template <typename Vector, typename Level>
inline BrightCount findRuns(const ImageRows<Level>& image, const PixelStrip* strips,
                            std::size_t count, int threshold, const BrightRuns& runs) {
  Vector limit;
  fill<Level>(threshold, &limit);
  const std::size_t bright = findBright(image, strips, count, limit, runs.rows);
  int* const first = runs.edges;
  const int* last = first + runs.room - image.columns - 1;
  int* edges = first;
  for (BrightRow* row = runs.rows; row != runs.rows + bright; ++row) {
    if (edges > last) return {static_cast<std::size_t>(row - runs.rows), false};
    edges = findEdges(image, *row, limit, edges);
    row->edges = static_cast<int>(edges - first);
  }
  return {bright, true};
}

template <typename Level>
BrightCount findRunsOf(const ImageRows<Level>& image, const PixelStrip* strips, std::size_t count,
                       int threshold, const BrightRuns& runs) {
  using Vector = std::conditional_t<sizeof(Level) == 1, ByteLanes, WordLanes>;
  return findRuns<Vector>(image, strips, count, threshold, runs);
}

/// Columns side by side from the first on: sums that only differ by powers of u are formed of the
/// columns'.
struct Columns {
  int first;
  Lanes u;
  Lanes m2;      ///< squared Mahalanobis distance at the centre's height
  Lanes slope2;  ///< its slope over v there
};

/// Visits a range's columns, none twice. Of the last ones, which are not beyond the row, those that
/// were visited lie outside of every ellipse.
template <typename Visit>
inline void forEachColumns(int image_columns, const PixelRange& range, const EllipseMetric& metric,
                           Visit visit) {
  constexpr float kFarOutside = 1e6F;  // whose cube still is a number
  const int last = image_columns - kPixelLanes;
  for (int column = range.first_column; column < range.last_column; column += kPixelLanes) {
    const int first = column < last ? column : last;
    const float u0 = static_cast<float>(first - metric.column) - metric.beyond_u;
    const Lanes u = __builtin_convertvector(kLane, Lanes) + u0;
    Lanes outside = Lanes{} + kFarOutside;
    keep(kLane < column - first, &outside);
    visit(Columns{first, u, metric.uu * u * u + outside, metric.uv * u});
  }
}

/// Visits the columns' pixels row by row: levels, v, and squared Mahalanobis distances.
template <typename Level, typename Visit>
inline void forEachRow(const ImageRows<Level>& image, const PixelRange& range,
                       const EllipseMetric& metric, const Columns& columns, Visit visit) {
  const Level* levels = rowOf(image, range.first_row) + columns.first;
  const std::ptrdiff_t step = range.row_step * image.stride;
  const float vv = metric.vv;
  Lanes v = Lanes{} + (static_cast<float>(range.first_row - metric.row) - metric.beyond_v);
  for (int row = range.first_row; row < range.last_row; row += range.row_step) {
    IntLanes wide;
    widen(levels, &wide);
    visit(__builtin_convertvector(wide, Lanes), v, columns.m2 + v * (columns.slope2 + vv * v));
    levels += step;
    v += static_cast<float>(range.row_step);
  }
}

template <typename Level>
RingSums sumRing(const ImageRows<Level>& image, const PixelRange& range,
                 const EllipseMetric& metric, float inner2, float outer2, float threshold,
                 float reference) {
  Lanes n{}, n_u{}, n_v{}, n_uu{}, n_uv{}, n_vv{}, lit{}, lit_u{}, lit_v{}, lit2{};
  forEachColumns(image.columns, range, metric, [&](const Columns& columns) {
    Lanes sum{}, sum_v{}, sum_lit{};
    forEachRow(image, range, metric, columns, [&](Lanes level, Lanes v, const Lanes& m2) {
      const IntLanes dark = (m2 > inner2) & (m2 <= outer2) & (level <= threshold);
      Lanes one = Lanes{} + 1.0F;
      level -= reference;
      keep(dark, &one);
      keep(dark, &v);
      keep(dark, &level);
      sum += one;
      sum_v += v;
      n_vv += v * v;
      sum_lit += level;
      lit_v += level * v;
      lit2 += level * level;
    });
    const Lanes u = columns.u;
    n += sum;
    n_u += sum * u;
    n_uu += sum * u * u;
    n_v += sum_v;
    n_uv += sum_v * u;
    lit += sum_lit;
    lit_u += sum_lit * u;
  });
  float sums[12];
  sumLanes(n, n_u, n_v, n_uu, sums);
  sumLanes(n_uv, n_vv, lit, lit_u, sums + 4);
  sumLanes(lit_v, lit2, lit_v, lit2, sums + 8);
  return {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7], sums[8], sums[9]};
}

template <typename Level>
CentreSums sumCentre(const ImageRows<Level>& image, const PixelRange& range,
                     const EllipseMetric& metric, float reach2, const PlaneTerms& plane,
                     const WeightTerms& weight) {
  const WeightTerms w = weight;
  const float slope_of_sixth = 3.0F * w.sixth;
  const float slope_v = plane.slope_v;
  Lanes light{}, weighted{}, moment_u{}, moment_v{}, sloped_uu{}, sloped_uv{}, sloped_vv{};
  forEachColumns(image.columns, range, metric, [&](const Columns& columns) {
    const Lanes u = columns.u;
    const Lanes background = plane.at_centre + plane.slope_u * u;
    Lanes sum_heavy{}, sum_sloped{}, sum_sloped_v{};
    forEachRow(image, range, metric, columns, [&](const Lanes& level, Lanes v, const Lanes& m2) {
      Lanes over = level - (background + slope_v * v);
      keep(m2 <= reach2, &over);
      const Lanes m4 = m2 * m2;
      const Lanes heavy = over * (w.constant + m2 * (w.square + w.sixth * m4));
      const Lanes sloped = over * (w.square + slope_of_sixth * m4);
      const Lanes sloped_v = sloped * v;
      light += over;
      sum_heavy += heavy;
      moment_v += heavy * v;
      sum_sloped += sloped;
      sum_sloped_v += sloped_v;
      sloped_vv += sloped_v * v;
    });
    weighted += sum_heavy;
    moment_u += sum_heavy * u;
    sloped_uu += sum_sloped * u * u;
    sloped_uv += sum_sloped_v * u;
  });
  float sums[8];
  sumLanes(light, weighted, moment_u, moment_v, sums);
  sumLanes(sloped_uu, sloped_uv, sloped_vv, sloped_vv, sums + 4);
  return {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6]};
}

template <typename Level>
SpreadSums sumSpread(const ImageRows<Level>& image, const ImageRows<Level>& sensed,
                     const PixelRange& range, const EllipseMetric& metric, float reach2,
                     const PlaneTerms& plane, const WeightTerms& weight, const NoiseTerms& noise) {
  const WeightTerms w = weight;
  const NoiseTerms t = noise;
  const float slope_v = plane.slope_v;
  const std::ptrdiff_t step = range.row_step * sensed.stride;
  Lanes light{}, light_uu{}, light_uv{}, light_vv{}, noise_uu{}, noise_uv{}, noise_vv{},
      fourth_powers{}, peak{};
  IntLanes full{};
  const Lanes nothing{};
  forEachColumns(image.columns, range, metric, [&](const Columns& columns) {
    const Lanes u = columns.u;
    const Lanes background = plane.at_centre + plane.slope_u * u;
    const Level* sensed_levels = rowOf(sensed, range.first_row) + columns.first;
    Lanes sum_light{}, sum_light_v{}, sum_noise{}, sum_noise_v{};
    forEachRow(image, range, metric, columns, [&](Lanes level, Lanes v, const Lanes& m2) {
      const IntLanes inside = m2 <= reach2;
      IntLanes sensed_level;
      widen(sensed_levels, &sensed_level);
      sensed_levels += step;
      const IntLanes is_full =
          inside & (__builtin_convertvector(sensed_level, Lanes) >= t.saturation);
      full -= is_full;  // each is -1
      keep(inside, &level);
      peak = peak < level ? level : peak;
      Lanes over = level - (background + slope_v * v);
      keep(inside, &over);
      Lanes photons = level - t.black;
      photons = photons > nothing ? photons : nothing;  // nothing outside, either
      keep(~is_full, &photons);
      const Lanes m4 = m2 * m2;
      const Lanes by_weight = w.constant + m2 * (w.square + w.sixth * m4);
      const Lanes noisy =
          (t.per_level * photons + t.per_square * over * over) * by_weight * by_weight;
      const Lanes light_v = over * v;
      const Lanes noise_v = noisy * v;
      sum_light += over;
      sum_light_v += light_v;
      light_vv += light_v * v;
      sum_noise += noisy;
      sum_noise_v += noise_v;
      noise_vv += noise_v * v;
      fourth_powers += over * m4;
    });
    light += sum_light;
    light_uu += sum_light * u * u;
    light_uv += sum_light_v * u;
    noise_uu += sum_noise * u * u;
    noise_uv += sum_noise_v * u;
  });
  int full_pixels = 0;
  for (int i = 0; i < kPixelLanes; ++i) full_pixels += full[i];
  float sums[8];
  sumLanes(light, light_uu, light_uv, light_vv, sums);
  sumLanes(noise_uu, noise_uv, noise_vv, fourth_powers, sums + 4);
  return {sums[0], sums[1], sums[2], sums[3],         sums[4],
          sums[5], sums[6], sums[7], largestOf(peak), full_pixels};
}

template <typename Level>
constexpr LevelKernels<Level> kKernels{findRunsOf<Level>, sumRing<Level>, sumCentre<Level>,
                                       sumSpread<Level>};

}  // namespace

const PixelKernels BEARING_CALIBRATION_KERNELS{kKernels<std::uint8_t>, kKernels<std::uint16_t>};

}  // namespace bearing_calibration::core
