#include "tools/study/comparison_estimators.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/live_filter.h"
#include "bench/reference/ceres_batch.h"
#include "tools/common/timing.h"
#include "tools/study/draws.h"

namespace bearing_calibration::core {
namespace {

/// How far a start may be from the truth: uniform in both directions.
struct StartSpread {
  double share;      ///< of distances
  double angle_rad;  ///< of angles
};

constexpr StartSpread kGood{0.1, radiansFromDegrees(10.0)};
constexpr StartSpread kPoor{0.5, radiansFromDegrees(60.0)};

/// Variance of what is uniform in an interval.
constexpr double uniformVariance(double half_width) { return half_width * half_width / 3.0; }

/// A start at the first observation, with the covariance of how it is drawn.
PaperEstimate drawStart(const ComparedRun& run, const StartSpread& spread) {
  Draws draws(run.seed, Draws::Purpose::kStart);
  PaperEstimate start = paperFromCartesian({run.truth.truth.front(), Matrix5::Identity()});
  start.covariance.setZero();
  for (const int i : {PaperIndex::kDistance, PaperIndex::kTheta, PaperIndex::kPhi, PaperIndex::kRho,
                      PaperIndex::kPsi}) {
    const bool is_distance = i == PaperIndex::kDistance || i == PaperIndex::kRho;
    const double half_width = is_distance ? spread.share * start.mean(i) : spread.angle_rad;
    start.mean(i) += draws.between(-half_width, half_width);
    start.covariance(i, i) = uniformVariance(half_width);
  }
  return start;
}

Snapshot snapshotOf(const ComparedRun& run, const CartesianEstimate& estimate,
                    double milliseconds) {
  const ConvergenceConfig targets = calibratorConfig(run.simulated).converged;
  Snapshot snapshot;
  snapshot.time_s = run.simulated.duration_s;
  snapshot.milliseconds = milliseconds;
  fillErrors(estimate, run.truth.truth.back(), snapshot);
  const Vector5 stddev = estimate.covariance.diagonal().cwiseSqrt();
  snapshot.claims =
      stddev.segment<2>(CartesianIndex::kSensorX).maxCoeff() <= targets.position_stddev_m &&
      stddev(CartesianIndex::kSensorYaw) <= targets.yaw_stddev_rad;
  return snapshot;
}

Snapshot runPaperFilterFrom(const ComparedRun& run, const StartSpread& spread) {
  const PaperEstimate start = drawStart(run, spread);
  CartesianEstimate estimate;
  const double milliseconds = cpuMillisecondsOf([&] {
    PaperFilter filter(start);
    for (const Observation& observation : run.observations) {
      if (&observation != &run.observations.front()) filter.predict(observation.motion);
      filter.update(observation.azimuth_rad, observation.azimuth_variance_rad2);
    }
    estimate = cartesianFromPaper(filter.estimate());
  });
  return snapshotOf(run, estimate, milliseconds);
}

/// The Cartesian EKF, with the likelihood of what it has seen.
struct LikelyFilter {
  explicit LikelyFilter(const CartesianEstimate& start) : filter(StateEstimate::of(start)) {}

  void update(const Observation& observation) {
    const Innovation innovation = filter.predictAzimuth().innovationOf(
        observation.azimuth_rad, observation.azimuth_variance_rad2);
    log_likelihood -= 0.5 * (innovation.nis() + std::log(innovation.variance));
    Bearing bearing;
    bearing.azimuth_rad = observation.azimuth_rad;
    bearing.azimuth_variance_rad2 = observation.azimuth_variance_rad2;
    filter.update(bearing);
  }

  LiveFilter filter;
  double log_likelihood = 0.0;  ///< but for a constant
};

/// The best of some filters after all observations.
CartesianEstimate estimateOfBest(std::vector<LikelyFilter> filters,
                                 const std::vector<Observation>& observations) {
  const LikelyFilter* best = nullptr;
  for (LikelyFilter& one : filters) {
    for (const Observation& observation : observations) {
      if (&observation != &observations.front()) one.filter.predict(observation.motion);
      one.update(observation);
    }
    if (best == nullptr || one.log_likelihood > best->log_likelihood) best = &one;
  }
  return best->filter.estimate().cartesian();
}

// What the bank covers: a sensor within half a metre in x and y, a light at 0.5 to 8 m.
constexpr double kFarthestMount_m = 0.5;
constexpr double kNearestLight_m = 0.5;
constexpr double kFarthestLight_m = 8.0;
constexpr int kRanges = 3;
constexpr int kYaws = 12;

/// A sensor at the base's centre with a yaw, and a light at a range where the bearing says it is.
CartesianEstimate bankStart(double range_m, double range_variance_m2, double yaw_rad,
                            const Observation& first) {
  const Eigen::Vector2d light = polar(range_m, yaw_rad + first.azimuth_rad);
  CartesianEstimate start;
  start.mean << light, 0.0, 0.0, wrapAngle(yaw_rad);
  // by range, azimuth, sensor x, y and yaw
  Matrix5 J_state_drawn = Matrix5::Zero();
  J_state_drawn.col(0).head<2>() = light / range_m;
  J_state_drawn.col(1).head<2>() = perpendicular(light);
  J_state_drawn.topRightCorner<2, 3>() << Eigen::Matrix2d::Identity(), perpendicular(light);
  J_state_drawn.bottomRightCorner<3, 3>().setIdentity();
  Vector5 variances;
  variances << range_variance_m2, first.azimuth_variance_rad2, uniformVariance(kFarthestMount_m),
      uniformVariance(kFarthestMount_m), uniformVariance(kPi / kYaws);
  start.covariance = J_state_drawn * variances.asDiagonal() * J_state_drawn.transpose();
  return start;
}

std::vector<LikelyFilter> filterBank(const Observation& first) {
  const double log_ratio = std::log(kFarthestLight_m / kNearestLight_m) / kRanges;
  std::vector<LikelyFilter> filters;
  for (int i = 0; i < kRanges; ++i) {
    const double range_m = kNearestLight_m * std::exp((i + 0.5) * log_ratio);
    const double variance_m2 = range_m * range_m * uniformVariance(0.5 * log_ratio);
    for (int j = 0; j < kYaws; ++j) {
      filters.emplace_back(bankStart(range_m, variance_m2, 2.0 * kPi * j / kYaws, first));
    }
  }
  return filters;
}

}  // namespace

ComparedRun comparedRun(const SimulatedCase& simulated, std::uint64_t seed) {
  ComparedRun run{simulated, seed, simulate(simulated), {}};
  run.observations = withNoise(run.truth.observations, simulated.stated_noise);
  return run;
}

Snapshot runCalibrator(const ComparedRun& run) {
  SimulatedCase simulated = run.simulated;
  simulated.looked_for = usualErrors();
  simulated.noise_looked_for = usualNoise();
  return tryCalibrator(simulated, {simulated.duration_s}).snapshots.back();
}

Snapshot runPaperFilter(const ComparedRun& run) { return runPaperFilterFrom(run, kGood); }

Snapshot runPaperFilterFromFar(const ComparedRun& run) { return runPaperFilterFrom(run, kPoor); }

Snapshot runFilterBank(const ComparedRun& run) {
  CartesianEstimate estimate;
  const double milliseconds = cpuMillisecondsOf(
      [&] { estimate = estimateOfBest(filterBank(run.observations.front()), run.observations); });
  return snapshotOf(run, estimate, milliseconds);
}

Snapshot runCeres(const ComparedRun& run) {
  constexpr double kNoLoss = 0.0;
  const RecordStart start(cartesianFromPaper(drawStart(run, kGood)).mean, 0);
  reference::CeresAnswer answer;
  const double milliseconds = cpuMillisecondsOf([&] {
    answer = reference::estimateByCeres(run.observations, start, kNoLoss,
                                        reference::CeresTolerance::kDefault,
                                        reference::CeresCovariance::kMount);
  });
  CartesianEstimate estimate;
  estimate.mean = answer.state;
  estimate.covariance.bottomRightCorner<3, 3>() = answer.mount_covariance;
  Snapshot snapshot = snapshotOf(run, estimate, milliseconds);
  snapshot.has_estimate = answer.converged && !answer.mount_covariance.isZero();
  snapshot.claims = snapshot.claims && snapshot.has_estimate;
  return snapshot;
}

Snapshot runKnownLight(const ComparedRun& run) {
  PaperEstimate start = drawStart(run, kGood);
  const PaperEstimate truth = paperFromCartesian({run.truth.truth.front(), Matrix5::Identity()});
  for (const int i : {PaperIndex::kDistance, PaperIndex::kTheta}) {
    start.mean(i) = truth.mean(i);
    start.covariance(i, i) = 0.0;
  }
  CartesianEstimate estimate;
  const double milliseconds = cpuMillisecondsOf([&] {
    estimate = estimateOfBest({LikelyFilter(cartesianFromPaper(start))}, run.observations);
  });
  return snapshotOf(run, estimate, milliseconds);
}

const std::vector<ComparedEstimator>& comparedEstimators() {
  static const std::vector<ComparedEstimator> kEstimators = {
      {"this package", "nothing; its own estimate of the noise begins at the stated one",
       runCalibrator},
      {"EKF, good start", "distances within 10 %, angles within 10 deg of the truth; the noise",
       runPaperFilter},
      {"EKF, poor start", "distances within 50 %, angles within 60 deg of the truth; the noise",
       runPaperFilterFromFar},
      {"36 EKFs", "a sensor within 0.5 m in x and y, a light at 0.5 to 8 m; the noise",
       runFilterBank},
      {"least squares by Ceres", "the start of the EKF with a good start; the noise", runCeres},
      {"EKF, known light",
       "where the light is as the robot starts, the mount of the good start; the noise",
       runKnownLight},
  };
  return kEstimators;
}

}  // namespace bearing_calibration::core
