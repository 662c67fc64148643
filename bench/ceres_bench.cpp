// Fit, search and batch of this package beside Ceres on the same problem: the same cost and loss,
// the same answer (test/property/ceres_test.cpp).
#include <benchmark/benchmark.h>

#include <vector>

#include "bearing_calibration/init/start_candidates.h"
#include "bench/paper_run.h"
#include "bench/reference/ceres_batch.h"

namespace bearing_calibration::core {
namespace {

using reference::CeresTolerance;

constexpr double kHuber = 2.0;  // as the package's fits have it
/// What the initialiser searches on, whatever the record's length.
constexpr std::size_t kSearchObservations = 150;

/// The first `count` observations of the run and a start near the truth.
struct BatchProblem {
  explicit BatchProblem(std::int64_t count)
      : observations(paperRun().observations.begin(), paperRun().observations.begin() + count),
        start{paperRun().truth[observations.size() - 1], observations.size() - 1} {}
  std::vector<Observation> observations;
  RecordStart start;
};

template <class Config>
void runBatch(benchmark::State& state, const Config& config) {
  const BatchProblem problem(state.range(0));
  const BatchEstimator estimator{config};
  for (auto _ : state) {
    benchmark::DoNotOptimize(estimator.estimate(problem.observations, problem.start));
  }
}

void runCeresBatch(benchmark::State& state, double huber_sigmas, CeresTolerance tolerance) {
  const BatchProblem problem(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        reference::estimateByCeres(problem.observations, problem.start, huber_sigmas, tolerance));
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

/// Observations of the first 20 s along a path that is taken as exact.
std::vector<PosedObservation> searchObservations() {
  constexpr std::ptrdiff_t kRecord = 200;
  const auto& all = paperRun().observations;
  std::vector<PosedObservation> observations =
      poseObservations(thinned({all.begin(), all.begin() + kRecord}, kSearchObservations));
  for (PosedObservation& observation : observations) {
    observation.heading_variance_rad2 = 0.0;
    observation.position_variance_m2 = 0.0;
  }
  return observations;
}

/// The truth with the light moved by 10 cm and the yaw by 3 degrees, about.
Vector5 nearStart() {
  Vector5 off;
  off << 0.1, -0.1, 0.03, 0.03, 0.05;
  return paperRun().truth.front() + off;
}

void fit(benchmark::State& state) {
  const std::vector<PosedObservation> observations = searchObservations();
  const FixedPathWeight weight{0, kHuber};
  for (auto _ : state) benchmark::DoNotOptimize(fitOnFixedPath(observations, nearStart(), weight));
}
void ceresFit(benchmark::State& state) {
  const std::vector<PosedObservation> observations = searchObservations();
  for (auto _ : state) {
    benchmark::DoNotOptimize(reference::fitOnFixedPathByCeres(observations, nearStart(), kHuber,
                                                              CeresTolerance::kDefault));
  }
}
void search(benchmark::State& state) {
  const std::vector<PosedObservation> observations = searchObservations();
  for (auto _ : state) {
    benchmark::DoNotOptimize(findConsensus(observations, {0, observations.size()}, 1));
  }
}
void ceresSearch(benchmark::State& state) {
  const std::vector<PosedObservation> observations = searchObservations();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        reference::findStartByCeres(observations, static_cast<int>(state.range(0)), kHuber));
  }
}
BENCHMARK(fit)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresFit)->Unit(benchmark::kMillisecond);
BENCHMARK(search)->Unit(benchmark::kMillisecond);
BENCHMARK(ceresSearch)->Arg(8)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bearing_calibration::core

BENCHMARK_MAIN();
