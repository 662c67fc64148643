// Compiled several times, with BEARING_CALIBRATION_KERNELS as the table's name.

#include "bearing_calibration/vision/pixel_kernels.h"

#include <cstring>
#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace bearing_calibration {

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

inline void load(const float* levels, Lanes* lanes) { std::memcpy(lanes, levels, kBytes); }

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

/// Pixels side by side: where they are and which of them are asked for.
struct Block {
  int row;
  int column;
  Lanes u;
  float v;
  IntLanes inside;
};

template <typename Visit>
inline void forEachBlock(const RowSpans& spans, int row_step, const WindowMetric& metric,
                         Visit visit) {
  Lanes first_u;
  for (int i = 0; i < kPixelLanes; ++i) first_u[i] = metric.u0 + static_cast<float>(i);
  const int* begins = spans.begin;
  const int* ends = spans.end;
  Block block;
  for (int piece = 0; piece < spans.pieces; ++piece, begins += spans.room, ends += spans.room) {
    for (int i = 0; i < spans.rows; i += row_step) {
      block.row = spans.first_row + i;
      block.v = metric.v0 + static_cast<float>(block.row);
      const int end = ends[i];
      for (block.column = begins[i]; block.column < end; block.column += kPixelLanes) {
        block.u = first_u + static_cast<float>(block.column);
        block.inside = kLane < end - block.column;
        visit(block);
      }
    }
  }
}

template <typename Level, typename Vector>
inline void fill(int threshold, Vector* limit) {
  constexpr int kMost = static_cast<Level>(-1);
  const Level level = static_cast<Level>(threshold < kMost ? threshold : kMost);
  *limit = Vector{} + level;
}

/// Writes the places of the intervals that have a pixel above the limit, or one shortly beside
/// them, and says how many these are; writes one place more. Mostly the scene is dark: its rows are
/// looked through without a branch.
template <typename Vector, typename Level>
inline std::size_t findBright(const ImageRows<Level>& image, const PixelInterval* intervals,
                              std::size_t count, const Vector& limit, std::size_t* found) {
  constexpr int kLevels = kBytes / static_cast<int>(sizeof(Level));
  std::size_t bright = 0;
  for (std::size_t i = 0; i < count;) {
    const PixelInterval first = intervals[i];
    // In whole vectors, and not beyond the row.
    const unsigned pixels = static_cast<unsigned>(first.end - first.begin);
    const int vectors = static_cast<int>((pixels + kLevels - 1) / kLevels);
    const int last = image.columns - vectors * kLevels;
    const int begin = first.begin < last ? first.begin : last;
    if (begin < 0) {  // an image narrower than a vector
      found[bright++] = i++;
      continue;
    }
    // As many rows as go on alike: all those of a box.
    const Level* row = rowOf(image, first.row) + begin;
    int next_row = first.row;
    do {
      Vector brightest = limit;
      for (int vector = 0; vector < vectors; ++vector) {
        Vector block;
        std::memcpy(&block, row + vector * kLevels, kBytes);
        brightest = brightest < block ? block : brightest;
      }
      found[bright] = i;  // the next one's place when it is dark
      bright += isZero(reinterpret_cast<IntLanes>(brightest ^ limit)) ? 0 : 1;
      row += image.stride;
      ++next_row;
      ++i;
    } while (i < count && intervals[i].row == next_row && intervals[i].begin == first.begin &&
             intervals[i].end == first.end);
  }
  return bright;
}

/// A bit for each of a block's levels, set where it is above the limit.
template <typename Vector, typename Level>
inline std::uint64_t brightBits(const Level* block, const Vector& limit) {
  return brightBits32(block, limit) | std::uint64_t{brightBits32(block + kBitsPerBlock / 2, limit)}
                                          << (kBitsPerBlock / 2);
}

/// Writes where the interval's runs begin and end, in turn. @return behind the last of these
template <typename Vector, typename Level>
inline int* findEdges(const ImageRows<Level>& image, const PixelInterval& interval,
                      const Vector& limit, int* edges) {
  constexpr int kBlock = kBitsPerBlock;
  const Level* row = rowOf(image, interval.row);
  const int end = interval.end;
  std::uint64_t carry = 0;  // whether the pixel before is bright
  for (int begin = interval.begin; begin < end; begin += kBlock) {
    const int left = end - begin;
    std::uint64_t bits = 0;
    if (begin + kBlock <= image.columns) {
      bits = brightBits(row + begin, limit);
    } else {
      Level block[kBlock] = {};
      for (int i = 0; i < image.columns - begin; ++i) block[i] = row[begin + i];
      bits = brightBits(block, limit);
    }
    if (left < kBlock) bits &= (std::uint64_t{1} << static_cast<unsigned>(left)) - 1;
    std::uint64_t changes = bits ^ (bits << 1U | carry);
    carry = bits >> (kBitsPerBlock - 1U);
    for (; changes != 0; changes &= changes - 1) *edges++ = begin + __builtin_ctzll(changes);
  }
  if (carry != 0) *edges++ = end;
  return edges;
}

template <typename Vector, typename Level>
inline BrightCount findRuns(const ImageRows<Level>& image, const PixelInterval* intervals,
                            std::size_t count, int threshold, const BrightRuns& runs) {
  Vector limit;
  fill<Level>(threshold, &limit);
  const std::size_t bright = findBright(image, intervals, count, limit, runs.intervals);
  const int* last = runs.edges + runs.room - image.columns - 1;
  int* edges = runs.edges;
  for (std::size_t i = 0; i < bright; ++i) {
    if (edges > last) return {i, false};
    edges = findEdges(image, intervals[runs.intervals[i]], limit, edges);
    runs.ends[i] = static_cast<int>(edges - runs.edges);
  }
  return {bright, true};
}

BrightCount findRunsOfBytes(const ImageRows<std::uint8_t>& image, const PixelInterval* intervals,
                            std::size_t count, int threshold, const BrightRuns& runs) {
  return findRuns<ByteLanes>(image, intervals, count, threshold, runs);
}

BrightCount findRunsOfWords(const ImageRows<std::uint16_t>& image, const PixelInterval* intervals,
                            std::size_t count, int threshold, const BrightRuns& runs) {
  return findRuns<WordLanes>(image, intervals, count, threshold, runs);
}

template <typename Level>
inline void copy(const ImageRows<Level>& image, int rows, float* levels, int stride) {
  const int last = image.columns - kPixelLanes;
  for (int v = 0; v < rows; ++v, levels += stride) {
    const Level* row = rowOf(image, v);
    if (last < 0) {
      for (int u = 0; u < image.columns; ++u) levels[u] = row[u];
      continue;
    }
    const auto copy_block = [&](int u) {
      IntLanes wide;
      widen(row + u, &wide);
      const Lanes numbers = __builtin_convertvector(wide, Lanes);
      std::memcpy(levels + u, &numbers, kBytes);
    };
    for (int u = 0; u < last; u += kPixelLanes) copy_block(u);
    copy_block(last);  // some once more rather than beyond the row
  }
}

void copyBytes(const ImageRows<std::uint8_t>& image, int rows, float* levels, int stride) {
  copy(image, rows, levels, stride);
}

void copyWords(const ImageRows<std::uint16_t>& image, int rows, float* levels, int stride) {
  copy(image, rows, levels, stride);
}

void cutChords(const EllipseChords& ellipse, int first_row, int rows, int columns, int* begin,
               int* end) {
  const EllipseChords e = ellipse;
  const float first_dv = static_cast<float>(first_row) - e.centre_v;
  const float last = static_cast<float>(columns);
  const int whole_lanes = (rows + kPixelLanes - 1) / kPixelLanes * kPixelLanes;
#pragma omp simd
  for (int i = 0; i < whole_lanes; ++i) {
    const float dv = first_dv + static_cast<float>(i);
    const float square = e.half2 - e.narrowing * dv * dv;
    const float half = __builtin_sqrtf(square > 0.0F ? square : 0.0F);
    const float middle = e.centre_u + e.skew * dv + 1.0F;  // a positive number is rounded down
    const float low = middle - half > 0.0F ? middle - half : 0.0F;
    const float high = middle + half > 0.0F ? middle + half : 0.0F;
    begin[i] = static_cast<int>(low < last ? low : last);
    end[i] = static_cast<int>(high < last ? high : last);
  }
}

RingSums sumRing(const LevelRows& patch, const RowSpans& spans, int row_step,
                 const WindowMetric& metric, float threshold, float reference) {
  Lanes n{}, n_u{}, n_v{}, n_uu{}, n_uv{}, n_vv{}, lit{}, lit_u{}, lit_v{}, lit2{};
  forEachBlock(spans, row_step, metric, [&](const Block& block) {
    Lanes level;
    load(patch.levels + block.row * patch.stride + block.column, &level);
    const IntLanes dark = block.inside & (level <= threshold);
    Lanes one = Lanes{} + 1.0F;
    Lanes u = block.u;
    level -= reference;
    keep(dark, &one);
    keep(dark, &u);
    keep(dark, &level);
    const Lanes v = one * block.v;
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
  });
  float sums[12];
  sumLanes(n, n_u, n_v, n_uu, sums);
  sumLanes(n_uv, n_vv, lit, lit_u, sums + 4);
  sumLanes(lit_v, lit2, lit_v, lit2, sums + 8);
  return {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7], sums[8], sums[9]};
}

/// A block's light over the background and its Mahalanobis distances.
struct Light {
  Light(const LevelRows& patch, const Block& block, const WindowMetric& metric,
        const PlaneTerms& plane) {
    load(patch.levels + block.row * patch.stride + block.column, &level);
    over = level - (plane.at_centre + plane.slope_v * block.v) - plane.slope_u * block.u;
    keep(block.inside, &over);
    m2 = (metric.uu * block.u + metric.uv * block.v) * block.u + metric.vv * block.v * block.v;
    m4 = m2 * m2;
  }

  Lanes level;
  Lanes over;
  Lanes m2;
  Lanes m4;
};

CentreSums sumCentre(const LevelRows& patch, const RowSpans& spans, int row_step,
                     const WindowMetric& metric, const PlaneTerms& plane,
                     const WeightTerms& weight) {
  const WindowMetric g = metric;
  const PlaneTerms b = plane;
  const WeightTerms w = weight;
  const float slope_of_sixth = 3.0F * w.sixth;
  Lanes light{}, weighted{}, moment_u{}, moment_v{}, sloped_uu{}, sloped_uv{}, sloped_vv{};
  forEachBlock(spans, row_step, g, [&](const Block& block) {
    const Light spot(patch, block, g, b);
    const Lanes heavy = spot.over * (w.constant + spot.m2 * (w.square + w.sixth * spot.m4));
    const Lanes sloped = spot.over * (w.square + slope_of_sixth * spot.m4);
    const Lanes sloped_u = sloped * block.u;
    const Lanes sloped_v = sloped * block.v;
    light += spot.over;
    weighted += heavy;
    moment_u += heavy * block.u;
    moment_v += heavy * block.v;
    sloped_uu += sloped_u * block.u;
    sloped_uv += sloped_u * block.v;
    sloped_vv += sloped_v * block.v;
  });
  float sums[8];
  sumLanes(light, weighted, moment_u, moment_v, sums);
  sumLanes(sloped_uu, sloped_uv, sloped_vv, sloped_vv, sums + 4);
  return {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6]};
}

SpreadSums sumSpread(const LevelRows& patch, const LevelRows& sensed, const RowSpans& spans,
                     int row_step, const WindowMetric& metric, const PlaneTerms& plane,
                     const WeightTerms& weight, const NoiseTerms& noise) {
  const WindowMetric g = metric;
  const PlaneTerms b = plane;
  const WeightTerms w = weight;
  const NoiseTerms t = noise;
  Lanes light{}, light_uu{}, light_uv{}, light_vv{}, noise_uu{}, noise_uv{}, noise_vv{},
      fourth_powers{}, peak{};
  IntLanes full{};
  forEachBlock(spans, row_step, g, [&](const Block& block) {
    const Light spot(patch, block, g, b);
    Lanes sensed_level;
    load(sensed.levels + block.row * sensed.stride + block.column, &sensed_level);
    const IntLanes is_full = block.inside & (sensed_level >= t.saturation);
    full -= is_full;  // each is -1
    Lanes photons = spot.level - t.black;
    keep(block.inside & ~is_full & (photons > 0.0F), &photons);
    const Lanes by_weight = w.constant + spot.m2 * (w.square + w.sixth * spot.m4);
    const Lanes noisy =
        (t.per_level * photons + t.per_square * spot.over * spot.over) * by_weight * by_weight;
    const Lanes uu = block.u * block.u;
    const Lanes uv = block.u * block.v;
    const float vv = block.v * block.v;
    light += spot.over;
    light_uu += spot.over * uu;
    light_uv += spot.over * uv;
    light_vv += spot.over * vv;
    noise_uu += noisy * uu;
    noise_uv += noisy * uv;
    noise_vv += noisy * vv;
    fourth_powers += spot.over * spot.m4;
    Lanes level = spot.level;
    keep(block.inside, &level);
    peak = peak < level ? level : peak;
  });
  int full_pixels = 0;
  for (int i = 0; i < kPixelLanes; ++i) full_pixels += full[i];
  float sums[8];
  sumLanes(light, light_uu, light_uv, light_vv, sums);
  sumLanes(noise_uu, noise_uv, noise_vv, fourth_powers, sums + 4);
  return {sums[0], sums[1], sums[2], sums[3],         sums[4],
          sums[5], sums[6], sums[7], largestOf(peak), full_pixels};
}

}  // namespace

const PixelKernels BEARING_CALIBRATION_KERNELS{findRunsOfBytes, findRunsOfWords, copyBytes,
                                               copyWords,       cutChords,       sumRing,
                                               sumCentre,       sumSpread};

}  // namespace bearing_calibration
