#include "tools/study/monte_carlo_trials.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/init/start_obstacle.h"
#include "tools/common/timing.h"
#include "tools/study/default_calibration.h"
#include "tools/study/lights_case.h"

namespace bearing_calibration::core {
namespace {

/// How much better than the targets the bound must be for a claim to be possible.
constexpr double kBoundMargin = 1.3;

/// Standard deviations that a claim stands for.
struct Targets {
  double position_m;
  double yaw_rad;
  double light_per_range;  ///< 0: any
};

/// Index of the last observation at or before a moment; the observations' stamps are those of the
/// truth.
std::size_t observationsUntil(const ObservationRun& run, double time_s) {
  const Stamp end = run.record.ticks.front().stamp + durationFromSeconds(time_s);
  std::size_t count = 0;
  while (count < run.observations.size() && run.observations[count].stamp <= end) ++count;
  return count;
}

/// At an image's stamp. Of several lights without numbers it is that of the nearest one to where
/// the estimate has its light.
Vector5 trueStateAt(const SimulatedCase& simulated, const ObservationRun& run, Stamp stamp,
                    const Eigen::Vector2d& light_in_base) {
  const auto image =
      std::lower_bound(run.at_images.begin(), run.at_images.end(), stamp,
                       [](const TrueState& state, Stamp wanted) { return state.stamp < wanted; });
  Vector5 truth = image->cartesian;
  if (simulated.lights.size() == 1 || simulated.are_lights_told) return truth;
  const Pose2 base_from_world = image->world_from_base.inverse();
  for (const Light& light : simulated.lights) {
    const Eigen::Vector2d place = base_from_world * light.position_m;
    if ((place - light_in_base).norm() < (truth.head<2>() - light_in_base).norm()) {
      truth.head<2>() = place;
    }
  }
  return truth;
}

/// Without the heights of several lights, which an estimate has in an order of its own.
void fillRobotErrors(const ErrorEstimate& found, const SimulatedCase& truth, Snapshot& snapshot) {
  snapshot.robot_error = found.mean - trueErrors(truth);
  snapshot.robot_stddev = found.covariance.diagonal().cwiseSqrt();
  if (truth.lights.size() > 1) snapshot.robot_stddev.tail<kMostLights>().setZero();
}

/// Covariance at the first `count` observations that no estimator can beat.
Matrix5 boundOf(const SimulatedCase& simulated, const ObservationRun& run, std::size_t count) {
  if (simulated.lights.size() > 1) {
    return lightsBound(simulated, run, count).cartesian().covariance;
  }
  const std::vector<Observation> observations(
      run.observations.begin(), run.observations.begin() + static_cast<std::ptrdiff_t>(count));
  std::vector<Eigen::Vector2d> lights;
  for (std::size_t i = 0; i < count; ++i) lights.push_back(run.truth[i].head<2>());
  return cramerRaoBound(observations, lights, run.truth[count - 1].tail<3>(), trueErrors(simulated),
                        simulated.looked_for)
      .cartesian()
      .covariance;
}

void fillBound(const SimulatedCase& simulated, const ObservationRun& run, std::size_t count,
               const Targets& targets, Snapshot& snapshot) {
  snapshot.bound = boundOf(simulated, run, count);
  const Vector5& truth = run.truth[count - 1];
  const Eigen::Vector2d p = truth.segment<2>(CartesianIndex::kSensorX);
  const double rho = p.norm();
  Eigen::Matrix3d J_polar_mount = Eigen::Matrix3d::Zero();  // (phi, rho, psi) by (x, y, yaw)
  J_polar_mount.topLeftCorner<1, 2>() = perpendicular(p).transpose() / (rho * rho);
  J_polar_mount.block<1, 2>(1, 0) = p.transpose() / rho;
  J_polar_mount.row(2) = Eigen::RowVector3d(0.0, 0.0, 1.0) - J_polar_mount.row(0);
  const Eigen::Matrix3d mount_bound = snapshot.bound.bottomRightCorner<3, 3>();
  snapshot.polar_bound = (J_polar_mount * mount_bound * J_polar_mount.transpose()).diagonal();

  const Vector5 stddev = kBoundMargin * snapshot.bound.diagonal().cwiseSqrt();
  const double range = (truth.head<2>() - p).norm();
  snapshot.possible = stddev(2) < targets.position_m && stddev(3) < targets.position_m &&
                      stddev(4) < targets.yaw_rad &&
                      (targets.light_per_range == 0.0 ||
                       stddev.head<2>().maxCoeff() < targets.light_per_range * range);
}

bool isSound(const RobotConfig& robot) {
  return robot.faults.slips.empty() && robot.sensor.outlier_probability == 0.0 &&
         robot.sensor.correlation == 0.0;
}

/// After fillErrors().
void compareWithWholeRecord(const SimulatedCase& simulated, const ObservationRun& run,
                            std::size_t count, Snapshot& snapshot) {
  const BatchConfig config = BatchConfig::leastSquares(simulated.looked_for);
  const std::vector<Observation> observations(
      run.observations.begin(), run.observations.begin() + static_cast<std::ptrdiff_t>(count));
  const Vector5& truth = run.truth[count - 1];
  const BatchEstimate whole =
      BatchEstimator(config).estimate(observations, {truth, count - 1, trueErrors(simulated)});
  if (!whole.converged) return;
  const Eigen::Vector3d calibrated = snapshot.error.tail<3>() + truth.tail<3>();
  snapshot.off_whole_record = mountDifference(calibrated, whole.last.mount().mean);
}

void noteClaim(const Snapshot& snapshot, Trial& trial) {
  if (!snapshot.claims) return;
  if (!trial.first_claim_s) trial.first_claim_s = snapshot.time_s;
  trial.worst_claim = std::max(trial.worst_claim, snapshot.mountChiSquare());
}

/// The batch over several lights, begun at the truth as the one over a single light is.
Trial tryLightsBatch(const SimulatedCase& simulated, const std::vector<double>& times_s) {
  const ObservationRun run = simulate(simulated);
  BatchConfig config;
  config.errors = simulated.looked_for;
  constexpr Targets kAny{1e3, 1e3, 0.0};
  Trial trial;
  for (double time_s : times_s) {
    const std::size_t count = observationsUntil(run, time_s);
    const std::vector<LightsImage> images = imagesOf(run, count);
    const std::vector<Observation> observations = allObservationsOf(simulated, images);
    const RecordTrack track = trueTrack(simulated, run, images);
    Snapshot snapshot;
    snapshot.time_s = time_s;
    BatchEstimate fit;
    snapshot.milliseconds =
        cpuMillisecondsOf([&] { fit = BatchEstimator(config).estimate(observations, track); });
    snapshot.claims = fit.converged;
    snapshot.words = fit.converged ? "converged" : "not settled";
    fillBound(simulated, run, count, kAny, snapshot);
    fillErrors(fit.last.cartesian(), run.truth[count - 1], snapshot);
    fillRobotErrors(fit.last.errors(), simulated, snapshot);
    noteClaim(snapshot, trial);
    trial.snapshots.push_back(snapshot);
  }
  return trial;
}

}  // namespace

CalibratorConfig calibratorConfig(const SimulatedCase& simulated) {
  const EncoderConfig& encoders = simulated.robot.encoders;
  WheelNoise told = encoders.noise;
  told.independent_k_m *= simulated.stated_noise.wheel.value;
  told.common_k_m *= simulated.stated_noise.wheel.value;
  CalibratorConfig config = defaultCalibration(encoders.drive, told);
  config.initializer.batch.errors = simulated.looked_for;
  config.max_lights = static_cast<int>(simulated.lights.size());
  config.initializer.noise = simulated.noise_looked_for;
  return config;
}

BearingSet toldOf(const SimulatedCase& simulated, const BearingSet& image) {
  constexpr double kNoMatter_m = 1.0;  // lights are points
  BearingSet told = image;
  told.candidates = withNoise(image.candidates, simulated.stated_noise, kNoMatter_m);
  if (!simulated.are_lights_told) {
    for (Bearing& light : told.candidates) light.light_id = kUnknownLight;
  }
  return told;
}

double Snapshot::mountChiSquare() const {
  const Eigen::Vector3d mount_error = error.tail<3>();
  const Eigen::Matrix3d mount_covariance = covariance.bottomRightCorner<3, 3>();
  return mount_error.dot(mount_covariance.ldlt().solve(mount_error));
}

void fillErrors(const CartesianEstimate& estimate, const Vector5& truth, Snapshot& snapshot) {
  snapshot.has_estimate = true;
  snapshot.error = estimate.mean - truth;
  snapshot.error(4) = wrapAngle(snapshot.error(4));
  snapshot.covariance = estimate.covariance;
  const Eigen::Vector2d p = estimate.sensorInBase();
  const Eigen::Vector2d p_true = truth.segment<2>(CartesianIndex::kSensorX);
  const double phi_error = wrapAngle(std::atan2(p.y(), p.x()) - std::atan2(p_true.y(), p_true.x()));
  snapshot.polar_error << phi_error, p.norm() - p_true.norm();
  snapshot.psi_error_rad = wrapAngle(snapshot.error(4) - phi_error);
}

double Snapshot::stateChiSquare() const { return error.dot(covariance.ldlt().solve(error)); }

Trial tryInitializer(const SimulatedCase& simulated, const std::vector<double>& times_s) {
  const ObservationRun run = simulate(simulated);
  InitializerConfig config;
  config.batch.errors = simulated.looked_for;
  const Targets targets{StartLimits::kMaxPositionStddev_m, StartLimits::kMaxYawStddev_rad,
                        StartLimits::kMaxLightStddevPerRange};
  Initializer initializer(config);
  Trial trial;
  std::size_t added = 0;
  for (double time_s : times_s) {
    const std::size_t count = observationsUntil(run, time_s);
    while (added < count) initializer.add(run.observations[added++]);
    Snapshot snapshot;
    snapshot.time_s = time_s;
    StartAttempt attempt;
    snapshot.milliseconds = cpuMillisecondsOf([&] { attempt = initializer.attempt(); });
    snapshot.claims = attempt.ready();
    snapshot.words = nameOf(attempt.obstacle);
    fillBound(simulated, run, count, targets, snapshot);
    if (attempt.ready()) {
      fillErrors(attempt.estimate.cartesian(), run.truth[count - 1], snapshot);
      fillRobotErrors(attempt.estimate.errors(), simulated, snapshot);
    }
    noteClaim(snapshot, trial);
    trial.snapshots.push_back(snapshot);
  }
  return trial;
}

Trial tryBatch(const SimulatedCase& simulated, const std::vector<double>& times_s) {
  if (simulated.lights.size() > 1) return tryLightsBatch(simulated, times_s);
  const ObservationRun run = simulate(simulated);
  BatchConfig config;
  config.errors = simulated.looked_for;
  const BatchEstimator estimator{config};
  const ErrorVector true_errors = trueErrors(simulated);
  constexpr Targets kAny{1e3, 1e3, 0.0};
  Trial trial;
  for (double time_s : times_s) {
    const std::size_t count = observationsUntil(run, time_s);
    const std::vector<Observation> observations(
        run.observations.begin(), run.observations.begin() + static_cast<std::ptrdiff_t>(count));
    Snapshot snapshot;
    snapshot.time_s = time_s;
    BatchEstimate estimate;
    snapshot.milliseconds = cpuMillisecondsOf([&] {
      estimate = estimator.estimate(observations, {run.truth[count - 1], count - 1, true_errors});
    });
    snapshot.claims = estimate.converged;
    snapshot.words = estimate.converged ? "converged" : "not settled";
    fillBound(simulated, run, count, kAny, snapshot);
    fillErrors(estimate.last.cartesian(), run.truth[count - 1], snapshot);
    fillRobotErrors(estimate.last.errors(), simulated, snapshot);
    noteClaim(snapshot, trial);
    trial.snapshots.push_back(snapshot);
  }
  return trial;
}

Trial tryCalibrator(const SimulatedCase& simulated, const std::vector<double>& times_s) {
  const ObservationRun run = simulate(simulated);
  const CalibratorConfig config = calibratorConfig(simulated);
  const Targets targets{config.converged.position_stddev_m, config.converged.yaw_stddev_rad, 0.0};
  constexpr double kAskEvery_s = 1.0;
  Calibrator calibrator(config);
  Trial trial;
  trial.is_sound = isSound(simulated.robot);
  auto bearings = run.record.bearings.begin();
  auto next_time = times_s.begin();
  double next_question_s = kAskEvery_s;
  double spent_ms = 0.0;
  for (const WheelCounts& ticks : run.record.ticks) {
    spent_ms += cpuMillisecondsOf([&] {
      for (; bearings != run.record.bearings.end() && bearings->stamp <= ticks.stamp; ++bearings) {
        calibrator.addBearings(toldOf(simulated, *bearings), bearings->stamp);
      }
      calibrator.addTicks(ticks, ticks.stamp);
    });
    const double time_s = secondsFromDuration(ticks.stamp - run.record.ticks.front().stamp);
    const bool due = next_time != times_s.end() && time_s >= *next_time;
    if (!due && time_s < next_question_s) continue;
    next_question_s += kAskEvery_s;
    const std::size_t count = observationsUntil(run, time_s);
    const CalibrationResult result = calibrator.result();
    Snapshot snapshot;
    snapshot.time_s = time_s;
    snapshot.milliseconds = spent_ms;
    snapshot.claims = result.state == CalibrationState::kConverged;
    snapshot.words = nameOf(result.state);
    if (result.cartesian_state) {
      fillErrors(*result.cartesian_state,
                 trueStateAt(simulated, run, result.stamp, result.cartesian_state->lightInBase()),
                 snapshot);
      fillRobotErrors(result.robot_errors, simulated, snapshot);
    }
    noteClaim(snapshot, trial);
    const bool is_alarm = result.state == CalibrationState::kInconsistent;
    if (is_alarm) trial.causes.insert(result.cause);
    if (is_alarm && trial.alarm.empty()) {
      trial.alarm = std::to_string(static_cast<int>(time_s)) + " s: " + result.advice;
    }
    if (!due) continue;
    ++next_time;
    fillBound(simulated, run, count, targets, snapshot);
    if (simulated.fit_whole_record && snapshot.has_estimate) {
      compareWithWholeRecord(simulated, run, count, snapshot);
    }
    trial.snapshots.push_back(snapshot);
  }
  return trial;
}

}  // namespace bearing_calibration::core
