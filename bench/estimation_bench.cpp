// Cost of the estimators: one filter step, one attempt to start, one batch over a whole record.
// Printed as times of this machine and as ratios in one run; nothing is asserted.
#include <benchmark/benchmark.h>

#include <vector>

#include "bearing_calibration/calibration/initializer.h"
#include "bearing_calibration/filter/mount_filter.h"
#include "bench/paper_run.h"

namespace bearing_calibration {
namespace {

CartesianEstimate goodStart() {
  CartesianEstimate start;
  start.mean = paperRun().truth.front();
  start.covariance = 1e-4 * Matrix5::Identity();
  return start;
}

/// What the filter does for one image at 10 Hz with encoders at 100 Hz: ten arcs, one prediction,
/// one update; the time given is that of a tenth of it, one encoder reading's share.
template <std::unique_ptr<MountFilter> (*Make)(const CartesianEstimate&)>
void filterStep(benchmark::State& state) {
  constexpr int kReadingsPerImage = 10;
  const std::unique_ptr<MountFilter> filter = Make(goodStart());
  const SightRun& run = paperRun();
  const WheelNoise noise{1e-6, 0.0};
  std::size_t i = 1;
  for (auto _ : state) {
    OdometryIncrement motion;
    const Pose2& way = run.sights[i].motion.start_from_end;
    for (int reading = 0; reading < kReadingsPerImage; ++reading) {
      const double distance = way.position_m.x() / kReadingsPerImage;
      const double half_turn = 0.125 * way.yaw_rad / kReadingsPerImage;
      motion = append(motion, {distance - half_turn, distance + half_turn}, 0.25, noise);
    }
    filter->predict(motion);
    filter->update(filter->predictAzimuth().azimuth_rad, 3e-4);
    benchmark::DoNotOptimize(filter->predictAzimuth());
    i = i + 1 < run.sights.size() ? i + 1 : 1;
  }
  state.SetItemsProcessed(state.iterations() * kReadingsPerImage);
}
BENCHMARK_TEMPLATE(filterStep, makeCartesianFilter);
BENCHMARK_TEMPLATE(filterStep, makePaperFilter);

/// One attempt of the initialiser on the first `range` sights.
void attempt(benchmark::State& state) {
  const auto& all = paperRun().sights;
  const std::vector<Sight> sights(all.begin(), all.begin() + state.range(0));
  const InitializerConfig config;
  for (auto _ : state) benchmark::DoNotOptimize(findStart(sights, config));
}
BENCHMARK(attempt)->Arg(150)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);

/// The batch over the first `range` sights from a start near the truth.
void batch(benchmark::State& state) {
  const SightRun& run = paperRun();
  const std::vector<Sight> sights(run.sights.begin(), run.sights.begin() + state.range(0));
  const BatchEstimator estimator{BatchConfig{}};
  const RecordStart start{run.truth[sights.size() - 1], sights.size() - 1};
  for (auto _ : state) benchmark::DoNotOptimize(estimator.estimate(sights, start));
}
BENCHMARK(batch)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bearing_calibration

BENCHMARK_MAIN();
