// Fit, search and batch of this package beside Ceres on the same problem: the same cost and loss,
// the same answer (test/property/ceres_test.cpp).
#include <benchmark/benchmark.h>

#include <vector>

#include "bearing_calibration/calibration/start_candidates.h"
#include "bench/paper_run.h"
#include "bench/reference/ceres_batch.h"

namespace bearing_calibration {
namespace {

using reference::CeresTolerance;

constexpr double kHuber = 2.0;  // as the package's fits have it
/// What the initialiser searches on, whatever the record's length.
constexpr std::size_t kSearchSights = 150;

/// The first `count` sights of the run and a start near the truth.
struct BatchProblem {
  explicit BatchProblem(std::int64_t count)
      : sights(paperRun().sights.begin(), paperRun().sights.begin() + count),
        start{paperRun().truth[sights.size() - 1], sights.size() - 1} {}
  std::vector<Sight> sights;
  RecordStart start;
};

template <class Config>
void runBatch(benchmark::State& state, const Config& config) {
  const BatchProblem problem(state.range(0));
  const BatchEstimator estimator{config};
  for (auto _ : state) {
    benchmark::DoNotOptimize(estimator.estimate(problem.sights, problem.start));
  }
}

void runCeresBatch(benchmark::State& state, double huber_sigmas, CeresTolerance tolerance) {
  const BatchProblem problem(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        reference::estimateByCeres(problem.sights, problem.start, huber_sigmas, tolerance));
  }
}

void batchPlain(benchmark::State& state) { runBatch(state, reference::costAlone(0.0)); }
void batchHuber(benchmark::State& state) { runBatch(state, reference::costAlone(kHuber)); }
void batchFull(benchmark::State& state) { runBatch(state, BatchConfig()); }
void ceresPlain(benchmark::State& state) { runCeresBatch(state, 0.0, CeresTolerance::kDefault); }
void ceresPlainTight(benchmark::State& state) { runCeresBatch(state, 0.0, CeresTolerance::kTight); }
void ceresHuber(benchmark::State& state) { runCeresBatch(state, kHuber, CeresTolerance::kDefault); }
BENCHMARK(batchPlain)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresPlain)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresPlainTight)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(batchHuber)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresHuber)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(batchFull)->Arg(1000)->Unit(benchmark::kMillisecond);

/// Sights of the first 20 s along a path that is taken as exact.
std::vector<PosedSight> searchSights() {
  constexpr std::ptrdiff_t kRecord = 200;
  const auto& all = paperRun().sights;
  std::vector<PosedSight> sights =
      poseSights(thinned({all.begin(), all.begin() + kRecord}, kSearchSights));
  for (PosedSight& sight : sights) {
    sight.heading_variance_rad2 = 0.0;
    sight.position_variance_m2 = 0.0;
  }
  return sights;
}

/// The truth with the light moved by 10 cm and the yaw by 3 degrees, about.
Vector5 nearStart() {
  Vector5 off;
  off << 0.1, -0.1, 0.03, 0.03, 0.05;
  return paperRun().truth.front() + off;
}

void fit(benchmark::State& state) {
  const std::vector<PosedSight> sights = searchSights();
  const FixedPathWeight weight{0, kHuber};
  for (auto _ : state) benchmark::DoNotOptimize(fitOnFixedPath(sights, nearStart(), weight));
}
void ceresFit(benchmark::State& state) {
  const std::vector<PosedSight> sights = searchSights();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        reference::fitOnFixedPathByCeres(sights, nearStart(), kHuber, CeresTolerance::kDefault));
  }
}
void search(benchmark::State& state) {
  const std::vector<PosedSight> sights = searchSights();
  for (auto _ : state) {
    benchmark::DoNotOptimize(findConsensus(sights, {0, sights.size()}, 1));
  }
}
void ceresSearch(benchmark::State& state) {
  const std::vector<PosedSight> sights = searchSights();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        reference::findStartByCeres(sights, static_cast<int>(state.range(0)), kHuber));
  }
}
BENCHMARK(fit)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresFit)->Unit(benchmark::kMillisecond);
BENCHMARK(search)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresSearch)->Arg(8)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bearing_calibration

BENCHMARK_MAIN();
