#include "bearing_calibration/vision/pixel_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace bearing_calibration::core {
namespace {

constexpr int kRows = 23;
constexpr int kThreshold = 150;

std::vector<const PixelKernels*> allTables() { return {&portablePixelKernels(), &pixelKernels()}; }

template <typename Level>
std::vector<Level> randomLevels(int columns, int most, std::mt19937* random) {
  std::uniform_int_distribution<int> level(0, most);
  std::vector<Level> levels(static_cast<std::size_t>(kRows * columns));
  for (Level& one : levels) one = static_cast<Level>(level(*random));
  return levels;
}

/// Runs as they are found one pixel after the other: row, begin, end.
struct Run {
  int row;
  int begin;
  int end;
  bool operator==(const Run& other) const {
    return row == other.row && begin == other.begin && end == other.end;
  }
};

template <typename Level>
std::vector<Run> plainRuns(const ImageRows<Level>& image, const std::vector<PixelStrip>& strips) {
  std::vector<Run> runs;
  for (const PixelStrip& strip : strips) {
    for (int v = strip.row; v < strip.row + strip.rows; ++v) {
      const Level* row = image.levels + v * image.stride;
      for (int u = strip.begin; u < strip.end; ++u) {
        if (row[u] <= kThreshold) continue;
        const bool goes_on = u > strip.begin && row[u - 1] > kThreshold;
        if (!goes_on) runs.push_back({v, u, u});
        runs.back().end = u + 1;
      }
    }
  }
  return runs;
}

template <typename Level>
std::vector<Run> runsBy(const LevelKernels<Level>& kernels, const ImageRows<Level>& image,
                        const std::vector<PixelStrip>& strips) {
  std::vector<BrightRow> rows(static_cast<std::size_t>(2 * kRows));
  std::vector<int> edges(static_cast<std::size_t>((kRows + 1) * (image.columns + 1)));
  const BrightCount count = kernels.findRuns(image, strips.data(), strips.size(), kThreshold,
                                             {rows.data(), edges.data(), edges.size()});
  EXPECT_TRUE(count.complete);
  std::vector<Run> runs;
  std::size_t edge = 0;
  for (std::size_t i = 0; i < count.rows; ++i) {
    for (; edge < static_cast<std::size_t>(rows[i].edges); edge += 2) {
      runs.push_back({rows[i].row, edges[edge], edges[edge + 1]});
    }
  }
  return runs;
}

/// Whole rows, boxes, and strips that lie anywhere, two of them in one row.
std::vector<std::vector<PixelStrip>> stripsOf(int columns) {
  std::vector<std::vector<PixelStrip>> all(3);
  for (int v = 0; v < kRows; ++v) all[0].push_back({v, 0, columns});
  for (int begin : {0, columns / 4}) {
    for (int end : {columns - columns / 8, columns}) {
      if (begin < end) all.push_back({{2, begin, end, kRows - 3}});
    }
  }
  for (int v = 0; v < kRows && columns >= 8; ++v) {
    all[1].push_back({v, columns / 4, columns - columns / 8});
    if (v % 3 == 1) continue;
    all[2].push_back({v, v % 4, columns / 2});
    all[2].push_back({v, columns / 2 + 1, columns - v % 2});
  }
  return all;
}

TEST(PixelKernels, FindTheRunsThatAPlainLoopFinds) {
  std::mt19937 random(1);
  for (const PixelKernels* kernels : allTables()) {
    for (int columns : {1, 7, 31, 32, 33, 63, 64, 65, 130, 200}) {
      const auto bytes = randomLevels<std::uint8_t>(columns, 255, &random);
      const auto words = randomLevels<std::uint16_t>(columns, 400, &random);
      for (const std::vector<PixelStrip>& strips : stripsOf(columns)) {
        const ImageRows<std::uint8_t> of_bytes{bytes.data(), columns, columns};
        const ImageRows<std::uint16_t> of_words{words.data(), columns, columns};
        EXPECT_EQ(runsBy(kernels->bytes, of_bytes, strips), plainRuns(of_bytes, strips))
            << columns << " columns";
        EXPECT_EQ(runsBy(kernels->words, of_words, strips), plainRuns(of_words, strips))
            << columns << " columns";
      }
    }
  }
}

TEST(PixelKernels, SayWhenThereAreMoreRunsThanRoom) {
  const std::vector<std::uint8_t> levels(static_cast<std::size_t>(kRows) * 64, 255);
  const ImageRows<std::uint8_t> image{levels.data(), 64, 64};
  std::vector<PixelStrip> strips;
  for (int v = 0; v < kRows; ++v) strips.push_back({v, 0, 64});
  std::vector<BrightRow> rows(strips.size());
  std::vector<int> edges(70);  // the room that a row may want is left for the first three
  for (const PixelKernels* kernels : allTables()) {
    const BrightCount count = kernels->bytes.findRuns(
        image, strips.data(), strips.size(), kThreshold, {rows.data(), edges.data(), edges.size()});
    EXPECT_FALSE(count.complete);
    EXPECT_EQ(count.rows, 3u);
  }
}

/// Noise about a light, in an image that cuts its ellipse on the right and below.
template <typename Level>
struct Scene {
  Scene() {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 2.0);
    for (int v = 0; v < kRows; ++v) {
      for (int u = 0; u < kColumns; ++u) {
        const double light = metricAt(u, v) < 4.0 ? 150.0 : 0.0;
        levels.push_back(static_cast<Level>(20.5 + 0.1 * u - 0.2 * v + light + noise(random)));
      }
    }
  }

  ImageRows<Level> rows() const { return {levels.data(), kColumns, kColumns}; }
  double levelAt(int u, int v) const { return levels[static_cast<std::size_t>(v * kColumns + u)]; }

  static double metricAt(int u, int v) {
    const double du = u - kCentreU;
    const double dv = v - kCentreV;
    return kUu * du * du + kUv * du * dv + kVv * dv * dv;
  }

  static constexpr int kColumns = 37;
  static constexpr double kCentreU = 30.3;
  static constexpr double kCentreV = 18.2;
  // The inverse of [9 2; 2 6].
  static constexpr double kUu = 0.12;
  static constexpr double kUv = -0.08;
  static constexpr double kVv = 0.18;
  std::vector<Level> levels;
};
using Bytes = Scene<std::uint8_t>;

constexpr double kReach2 = 6.25;
const EllipseMetric kMetric{30,
                            18,
                            static_cast<float>(Bytes::kCentreU - 30.0),
                            static_cast<float>(Bytes::kCentreV - 18.0),
                            static_cast<float>(Bytes::kUu),
                            static_cast<float>(Bytes::kUv),
                            static_cast<float>(Bytes::kVv)};
constexpr PlaneTerms kPlane{19.6F, 0.1F, -0.2F};
constexpr WeightTerms kWeight{0.0F, 1.0F, -1.0F / 39.0625F};
constexpr NoiseTerms kNoise{4.0F, 170.0F, 0.1F, 1e-4F};

/// More than the ellipse; its columns are no multiple of what a loop takes at once.
constexpr PixelRange rangeOf(int row_step) { return {1, kRows, row_step, 14, Bytes::kColumns}; }

/// Equal to what a sum of so many floats keeps.
void expectNear(float sum, double expected, double scale) {
  EXPECT_NEAR(static_cast<double>(sum), expected, 1e-5 * scale);
}

template <typename Level>
void expectSumsOfAPlainLoop(const LevelKernels<Level>& kernels, int row_step) {
  const Scene<Level> scene;
  const PixelRange range = rangeOf(row_step);
  double light = 0.0;
  double weighted = 0.0;
  double moment_u = 0.0;
  double sloped_uv = 0.0;
  double light_uu = 0.0;
  double light_vv = 0.0;
  double noise_uu = 0.0;
  double fourth_powers = 0.0;
  double peak = 0.0;
  int full = 0;
  for (int v = range.first_row; v < range.last_row; v += row_step) {
    for (int u = range.first_column; u < range.last_column; ++u) {
      const double m2 = scene.metricAt(u, v);
      if (m2 > kReach2) continue;
      const double du = u - scene.kCentreU;
      const double dv = v - scene.kCentreV;
      const double level = scene.levelAt(u, v);
      const double over = level - 19.6 - 0.1 * du + 0.2 * dv;
      const double weight = m2 * (1.0 - m2 * m2 / 39.0625);
      const bool is_full = level >= 170.0;
      const double variance =
          (is_full ? 0.0 : 0.1 * std::max(0.0, level - 4.0)) + 1e-4 * over * over;
      light += over;
      weighted += over * weight;
      moment_u += over * weight * du;
      sloped_uv += over * (1.0 - 3.0 * m2 * m2 / 39.0625) * du * dv;
      light_uu += over * du * du;
      light_vv += over * dv * dv;
      noise_uu += variance * weight * weight * du * du;
      fourth_powers += over * m2 * m2;
      peak = std::max(peak, level);
      full += is_full ? 1 : 0;
    }
  }
  ASSERT_GT(full, 3);
  const CentreSums centre =
      kernels.sumCentre(scene.rows(), range, kMetric, kReach2, kPlane, kWeight);
  expectNear(centre.light, light, light);
  expectNear(centre.weighted, weighted, weighted);
  expectNear(centre.moment_u, moment_u, 10.0 * weighted);
  expectNear(centre.sloped_uv, sloped_uv, 10.0 * weighted);
  const SpreadSums spread = kernels.sumSpread(scene.rows(), scene.rows(), range, kMetric, kReach2,
                                              kPlane, kWeight, kNoise);
  expectNear(spread.light, light, light);
  expectNear(spread.light_uu, light_uu, light_uu);
  expectNear(spread.light_vv, light_vv, light_vv);
  expectNear(spread.noise_uu, noise_uu, noise_uu);
  expectNear(spread.fourth_powers, fourth_powers, fourth_powers);
  EXPECT_EQ(static_cast<double>(spread.peak), peak);
  EXPECT_EQ(spread.full_pixels, full);
}

TEST(PixelKernels, SumAnEllipseAsAPlainLoopDoes) {
  for (const PixelKernels* kernels : allTables()) {
    for (int row_step : {1, 2}) {
      expectSumsOfAPlainLoop(kernels->bytes, row_step);
      expectSumsOfAPlainLoop(kernels->words, row_step);
    }
  }
}

TEST(PixelKernels, CountFullPixelsInTheImageThatTheSensorTook) {
  const Bytes scene;
  const std::vector<std::uint8_t> full(scene.levels.size(), 200);
  for (const PixelKernels* kernels : allTables()) {
    const SpreadSums spread =
        kernels->bytes.sumSpread(scene.rows(), {full.data(), Bytes::kColumns, Bytes::kColumns},
                                 rangeOf(1), kMetric, 1.0F, kPlane, kWeight, kNoise);
    int pixels = 0;
    for (int v = 0; v < kRows; ++v) {
      for (int u = 0; u < Bytes::kColumns; ++u) pixels += Bytes::metricAt(u, v) <= 1.0 ? 1 : 0;
    }
    EXPECT_EQ(spread.full_pixels, pixels);
  }
}

TEST(PixelKernels, SumTheDarkPixelsOfARing) {
  const Bytes scene;
  const PixelRange range = rangeOf(1);
  double n = 0.0;
  double n_u = 0.0;
  double n_uv = 0.0;
  double level_v = 0.0;
  double level2 = 0.0;
  for (int v = range.first_row; v < range.last_row; ++v) {
    for (int u = range.first_column; u < range.last_column; ++u) {
      const double m2 = Bytes::metricAt(u, v);
      const double level = scene.levelAt(u, v);
      if (m2 <= 4.0 || m2 > 9.0 || level > 21.0) continue;
      n += 1.0;
      n_u += u - Bytes::kCentreU;
      n_uv += (u - Bytes::kCentreU) * (v - Bytes::kCentreV);
      level_v += (level - 20.0) * (v - Bytes::kCentreV);
      level2 += (level - 20.0) * (level - 20.0);
    }
  }
  ASSERT_GT(n, 30.0);
  for (const PixelKernels* kernels : allTables()) {
    const RingSums sums =
        kernels->bytes.sumRing(scene.rows(), range, kMetric, 4.0F, 9.0F, 21.0F, 20.0F);
    EXPECT_EQ(static_cast<double>(sums.n), n);
    expectNear(sums.u, n_u, 10.0 * n);
    expectNear(sums.uv, n_uv, 50.0 * n);
    expectNear(sums.level_v, level_v, 10.0 * n);
    expectNear(sums.level2, level2, level2);
  }
}

}  // namespace
}  // namespace bearing_calibration::core
