#include "bearing_calibration/vision/pixel_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace bearing_calibration {
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
std::vector<Run> plainRuns(const ImageRows<Level>& image,
                           const std::vector<PixelInterval>& intervals) {
  std::vector<Run> runs;
  for (const PixelInterval& interval : intervals) {
    const Level* row = image.levels + interval.row * image.stride;
    for (int u = interval.begin; u < interval.end; ++u) {
      if (row[u] <= kThreshold) continue;
      const bool goes_on = u > interval.begin && row[u - 1] > kThreshold;
      if (!goes_on) runs.push_back({interval.row, u, u});
      runs.back().end = u + 1;
    }
  }
  return runs;
}

template <typename Level, typename Find>
std::vector<Run> runsBy(Find find, const ImageRows<Level>& image,
                        const std::vector<PixelInterval>& intervals) {
  std::vector<std::size_t> places(intervals.size() + 1);
  std::vector<int> ends(intervals.size());
  std::vector<int> edges(static_cast<std::size_t>((kRows + 1) * (image.columns + 1)));
  const BrightCount count = find(image, intervals.data(), intervals.size(), kThreshold,
                                 {places.data(), ends.data(), edges.data(), edges.size()});
  EXPECT_TRUE(count.complete);
  std::vector<Run> runs;
  std::size_t edge = 0;
  for (std::size_t i = 0; i < count.intervals; ++i) {
    for (; edge < static_cast<std::size_t>(ends[i]); edge += 2) {
      runs.push_back({intervals[places[i]].row, edges[edge], edges[edge + 1]});
    }
  }
  return runs;
}

/// Whole rows, a box, and intervals that lie anywhere, two of them in one row.
std::vector<std::vector<PixelInterval>> intervalsOf(int columns) {
  std::vector<std::vector<PixelInterval>> all(3);
  for (int v = 0; v < kRows; ++v) {
    all[0].push_back({v, 0, columns});
    if (columns < 8) continue;
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
      for (const std::vector<PixelInterval>& intervals : intervalsOf(columns)) {
        const ImageRows<std::uint8_t> of_bytes{bytes.data(), columns, columns};
        const ImageRows<std::uint16_t> of_words{words.data(), columns, columns};
        EXPECT_EQ(runsBy(kernels->findRunsOfBytes, of_bytes, intervals),
                  plainRuns(of_bytes, intervals))
            << columns << " columns";
        EXPECT_EQ(runsBy(kernels->findRunsOfWords, of_words, intervals),
                  plainRuns(of_words, intervals))
            << columns << " columns";
      }
    }
  }
}

TEST(PixelKernels, SayWhenThereAreMoreRunsThanRoom) {
  const std::vector<std::uint8_t> levels(static_cast<std::size_t>(kRows) * 64, 255);
  const ImageRows<std::uint8_t> image{levels.data(), 64, 64};
  std::vector<PixelInterval> intervals;
  for (int v = 0; v < kRows; ++v) intervals.push_back({v, 0, 64});
  std::vector<std::size_t> places(intervals.size() + 1);
  std::vector<int> ends(intervals.size());
  std::vector<int> edges(70);  // the room that a row may want is left for the first three
  for (const PixelKernels* kernels : allTables()) {
    const BrightCount count =
        kernels->findRunsOfBytes(image, intervals.data(), intervals.size(), kThreshold,
                                 {places.data(), ends.data(), edges.data(), edges.size()});
    EXPECT_FALSE(count.complete);
    EXPECT_EQ(count.intervals, 3u);
  }
}

TEST(PixelKernels, CopyLevels) {
  std::mt19937 random(2);
  for (const PixelKernels* kernels : allTables()) {
    for (int columns : {1, 5, 8, 9, 40}) {
      const auto bytes = randomLevels<std::uint8_t>(columns, 255, &random);
      const auto words = randomLevels<std::uint16_t>(columns, 65535, &random);
      std::vector<float> copied(bytes.size());
      kernels->copyBytes({bytes.data(), columns, columns}, kRows, copied.data(), columns);
      EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), copied.begin()));
      kernels->copyWords({words.data(), columns, columns}, kRows, copied.data(), columns);
      EXPECT_TRUE(std::equal(words.begin(), words.end(), copied.begin()));
    }
  }
}

/// A patch of noise about a light, and an ellipse in it.
struct Scene {
  Scene() {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 2.0);
    for (int v = 0; v < kRows; ++v) {
      for (int u = 0; u < kColumns; ++u) {
        const double light = metricAt(u, v) < 4.0 ? 150.0 : 0.0;
        levels.push_back(static_cast<float>(20.0 + 0.1 * u - 0.2 * v + light + noise(random)));
      }
    }
    levels.resize(levels.size() + kPixelLanes);
  }

  double metricAt(int u, int v) const {
    const double du = u - kCentreU;
    const double dv = v - kCentreV;
    return kUu * du * du + kUv * du * dv + kVv * dv * dv;
  }

  static constexpr int kColumns = 37;
  static constexpr double kCentreU = 18.3;
  static constexpr double kCentreV = 11.2;
  // The inverse of [9 2; 2 6].
  static constexpr double kUu = 0.12;
  static constexpr double kUv = -0.08;
  static constexpr double kVv = 0.18;
  static constexpr double kReach = 2.5;
  std::vector<float> levels;
};

struct Chords {
  Chords(const PixelKernels& kernels, double reach)
      : begin(static_cast<std::size_t>(kRows + kPixelLanes)), end(begin.size()) {
    constexpr double kChordVar = 1.0 / Scene::kUu;
    kernels.cutChords(
        {static_cast<float>(Scene::kCentreU), static_cast<float>(Scene::kCentreV), 2.0F / 6.0F,
         static_cast<float>(kChordVar / 6.0), static_cast<float>(kChordVar * reach * reach)},
        0, kRows, Scene::kColumns, begin.data(), end.data());
  }

  RowSpans spans() const { return {0, kRows, 0, 1, begin.data(), end.data()}; }

  std::vector<int> begin;
  std::vector<int> end;
};

TEST(PixelKernels, AChordIsTheEllipsesPixelsOfARow) {
  const Scene scene;
  for (const PixelKernels* kernels : allTables()) {
    const Chords chords(*kernels, Scene::kReach);
    for (int v = 0; v < kRows; ++v) {
      const auto row = static_cast<std::size_t>(v);
      for (int u = 0; u < Scene::kColumns; ++u) {
        const bool inside = scene.metricAt(u, v) <= Scene::kReach * Scene::kReach;
        EXPECT_EQ(u >= chords.begin[row] && u < chords.end[row], inside) << u << ", " << v;
      }
    }
  }
}

const WindowMetric kMetric{static_cast<float>(-Scene::kCentreU),
                           static_cast<float>(-Scene::kCentreV), static_cast<float>(Scene::kUu),
                           static_cast<float>(Scene::kUv), static_cast<float>(Scene::kVv)};
constexpr PlaneTerms kPlane{19.6F, 0.1F, -0.2F};
constexpr WeightTerms kWeight{0.0F, 1.0F, -1.0F / 39.0625F};
constexpr NoiseTerms kNoise{4.0F, 170.0F, 0.1F, 1e-4F};

/// Equal to what a sum of so many floats keeps.
void expectNear(float sum, double expected, double scale) {
  EXPECT_NEAR(static_cast<double>(sum), expected, 1e-5 * scale);
}

TEST(PixelKernels, SumAWindowAsAPlainLoopDoes) {
  const Scene scene;
  for (int row_step : {1, 2}) {
    double light = 0.0;
    double weighted = 0.0;
    double moment_u = 0.0;
    double sloped_uv = 0.0;
    double light_vv = 0.0;
    double noise_uu = 0.0;
    double fourth_powers = 0.0;
    double peak = 0.0;
    int full = 0;
    for (int v = 0; v < kRows; ++v) {
      for (int u = 0; u < Scene::kColumns; ++u) {
        const double m2 = scene.metricAt(u, v);
        if (m2 > Scene::kReach * Scene::kReach || v % row_step != 0) continue;
        const double du = u - Scene::kCentreU;
        const double dv = v - Scene::kCentreV;
        const auto level =
            static_cast<double>(scene.levels[static_cast<std::size_t>(v * Scene::kColumns + u)]);
        const double over = level - 19.6 - 0.1 * du + 0.2 * dv;
        const double weight = m2 * (1.0 - m2 * m2 / 39.0625);
        const bool is_full = level >= 170.0;
        const double variance =
            (is_full ? 0.0 : 0.1 * std::max(0.0, level - 4.0)) + 1e-4 * over * over;
        light += over;
        weighted += over * weight;
        moment_u += over * weight * du;
        sloped_uv += over * (1.0 - 3.0 * m2 * m2 / 39.0625) * du * dv;
        light_vv += over * dv * dv;
        noise_uu += variance * weight * weight * du * du;
        fourth_powers += over * m2 * m2;
        peak = std::max(peak, level);
        full += is_full ? 1 : 0;
      }
    }
    ASSERT_GT(full, 3);
    for (const PixelKernels* kernels : allTables()) {
      const Chords chords(*kernels, Scene::kReach);
      const LevelRows patch{scene.levels.data(), Scene::kColumns};
      const CentreSums centre =
          kernels->sumCentre(patch, chords.spans(), row_step, kMetric, kPlane, kWeight);
      expectNear(centre.light, light, light);
      expectNear(centre.weighted, weighted, weighted);
      expectNear(centre.moment_u, moment_u, 10.0 * weighted);
      expectNear(centre.sloped_uv, sloped_uv, 10.0 * weighted);
      const SpreadSums spread = kernels->sumSpread(patch, patch, chords.spans(), row_step, kMetric,
                                                   kPlane, kWeight, kNoise);
      expectNear(spread.light, light, light);
      expectNear(spread.light_vv, light_vv, light_vv);
      expectNear(spread.noise_uu, noise_uu, noise_uu);
      expectNear(spread.fourth_powers, fourth_powers, fourth_powers);
      EXPECT_EQ(static_cast<double>(spread.peak), peak);
      EXPECT_EQ(spread.full_pixels, full);
    }
  }
}

TEST(PixelKernels, SumARingInTwoPieces) {
  const Scene scene;
  double n = 0.0;
  double n_uv = 0.0;
  double level_v = 0.0;
  double level2 = 0.0;
  for (int v = 0; v < kRows; ++v) {
    for (int u = 0; u < Scene::kColumns; ++u) {
      const double m2 = scene.metricAt(u, v);
      const auto level =
          static_cast<double>(scene.levels[static_cast<std::size_t>(v * Scene::kColumns + u)]);
      if (m2 <= 4.0 || m2 > 9.0 || level > 21.0) continue;
      n += 1.0;
      n_uv += (u - Scene::kCentreU) * (v - Scene::kCentreV);
      level_v += (level - 20.0) * (v - Scene::kCentreV);
      level2 += (level - 20.0) * (level - 20.0);
    }
  }
  ASSERT_GT(n, 50.0);
  for (const PixelKernels* kernels : allTables()) {
    const Chords inner(*kernels, 2.0);
    const Chords outer(*kernels, 3.0);
    std::vector<int> begin(outer.begin.begin(), outer.begin.begin() + kRows);
    begin.insert(begin.end(), inner.end.begin(), inner.end.begin() + kRows);
    std::vector<int> end(inner.begin.begin(), inner.begin.begin() + kRows);
    end.insert(end.end(), outer.end.begin(), outer.end.begin() + kRows);
    const RingSums sums =
        kernels->sumRing({scene.levels.data(), Scene::kColumns},
                         {0, kRows, kRows, 2, begin.data(), end.data()}, 1, kMetric, 21.0F, 20.0F);
    EXPECT_EQ(static_cast<double>(sums.n), n);
    expectNear(sums.uv, n_uv, 50.0 * n);
    expectNear(sums.level_v, level_v, 10.0 * n);
    expectNear(sums.level2, level2, level2);
  }
}

}  // namespace
}  // namespace bearing_calibration
