#include "bearing_calibration/calibration/cartesian_smoother.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration {
namespace {

/// Variance of Huber's bounded pull over that of an ordinary bearing's, for a sight that is mostly
/// doubted: its square at 2 standard deviations where a fifth of all sights are outliers.
constexpr double kDoubtfulPull = 1.6;

/// The state with K of the robot's errors behind it.
template <int K>
using StateVector = Eigen::Matrix<double, 5 + K, 1>;
template <int K>
using StateMatrix = Eigen::Matrix<double, 5 + K, 5 + K>;

/// One measured number, linearised about the path.
template <int K>
struct LinearNumber {
  Eigen::Matrix<double, 1, 5 + K> H;
  StateVector<K> gain;
  double innovation;  ///< against the state before it, through the linearisation at the path
  double innovation_variance;
  double pull_variance;  ///< of innovation / innovation_variance
};

/// What the backward pass needs from the forward one.
template <int K>
struct ForwardStep {
  StateVector<K> predicted;
  StateMatrix<K> predicted_covariance;
  LinearNumber<K> azimuth;
  bool used;
};

/// A motion linearised about its own error and those of the robot:
/// l+ = R (l - t) + J (error - error*) + J_errors (errors - errors*).
template <int K>
struct LinearMotion {
  Pose2 start_from_end;  ///< the measured one with its error* put right
  Eigen::Matrix2d R_end_start;
  Eigen::Matrix<double, 2, 3> J_light_error;
  Eigen::Matrix<double, 2, K> J_light_errors;
  Eigen::Matrix3d covariance;  ///< of the motion's own error

  Eigen::Matrix2d lightNoise() const {
    return J_light_error * covariance * J_light_error.transpose();
  }
};

template <int K>
LinearMotion<K> lineariseMotion(const Sight& sight, bool slipped, const PathPoint& point,
                                const ErrorVector& errors) {
  const CorrectedMotion<K> corrected = correctMotion<K>(sight.motion, errors);
  const Pose2& measured = corrected.start_from_end;
  LinearMotion<K> motion;
  motion.start_from_end = {measured.position_m + point.motion_error.head<2>(),
                           wrapAngle(measured.yaw_rad + point.motion_error(2))};
  motion.R_end_start = rotation2(-motion.start_from_end.yaw_rad);
  motion.J_light_error << -motion.R_end_start,
      -perpendicular(Eigen::Vector2d(point.state.head<2>()));
  motion.J_light_errors = motion.J_light_error * corrected.J_pose_errors;
  motion.covariance = sight.motion.covariance;
  if (slipped) motion.covariance += slipCovariance();
  return motion;
}

template <int K>
void predict(const LinearMotion<K>& motion, const Eigen::Vector3d& error,
             const Eigen::Matrix<double, K, 1>& errors_at_path, StateVector<K>& mean,
             StateMatrix<K>& covariance) {
  const Eigen::Vector2d light = mean.template head<2>();
  mean.template head<2>() = motion.R_end_start * (light - motion.start_from_end.position_m) -
                            motion.J_light_error * error;
  if constexpr (K > 0) {
    mean.template head<2>() += motion.J_light_errors * (mean.template tail<K>() - errors_at_path);
  }
  propagateCovariance<K>(motion.R_end_start, motion.J_light_errors, motion.lightNoise(),
                         covariance);
}

/// @param residual  at the path
/// @param variance  of the measurement, larger than the ordinary one where it is doubted
template <int K>
LinearNumber<K> linearise(const Eigen::Matrix<double, 1, 5 + K>& H, double residual,
                          double variance, double ordinary_variance, const StateVector<K>& path,
                          const StateVector<K>& mean, const StateMatrix<K>& covariance) {
  LinearNumber<K> number;
  number.H = H;
  number.innovation = residual - (H * (mean - path)).value();
  const StateVector<K> PHt = covariance * H.transpose();
  number.innovation_variance = (H * PHt).value() + variance;
  number.pull_variance = 1.0 / number.innovation_variance;
  if (variance > ordinary_variance) {
    // The pull of a doubtful bearing is bounded by its weight, but it is not as small as a bearing
    // of so large a variance would have it: else a few outliers look like a slip.
    number.pull_variance = kDoubtfulPull / ((H * PHt).value() + ordinary_variance);
  }
  number.gain = PHt / number.innovation_variance;
  return number;
}

template <int K>
StateVector<K> pathState(const Vector5& state, const ErrorVector& errors) {
  StateVector<K> path;
  path << state, errors.head<K>();
  return path;
}

template <int K>
ForwardStep<K> lineariseSight(const Sight& sight, const SightWeight& weight, const Vector5& state,
                              const ErrorVector& errors, const StateVector<K>& mean,
                              const StateMatrix<K>& covariance) {
  const SightModel<K> expected = expectSight<K>(state, errors, sight.nearby);
  ForwardStep<K> step{mean, covariance, {}, weight.use_bearing};
  step.azimuth =
      linearise<K>(expected.J_azimuth_state, wrapAngle(sight.azimuth_rad - expected.azimuth_rad),
                   weight.bearing_variance_rad2, weight.sensor_variance_rad2,
                   pathState<K>(state, errors), mean, covariance);
  return step;
}

/// After the azimuth of the same sight.
LinearNumber<kErrorCount> lineariseElevation(const Sight& sight, double doubt, const Vector5& state,
                                             const ErrorVector& errors,
                                             const StateVector<kErrorCount>& mean,
                                             const StateMatrix<kErrorCount>& covariance) {
  const ElevationModel expected = expectElevation(state, errors, sight.nearby);
  const double variance = sight.elevation->variance_rad2;
  return linearise<kErrorCount>(
      expected.J_elevation_state, sight.elevation->angle_rad - expected.elevation_rad,
      doubt * variance, variance, pathState<kErrorCount>(state, errors), mean, covariance);
}

double rangeOf(const Vector5& state) {
  return (state.head<2>() - state.segment<2>(CartesianIndex::kSensorX)).norm();
}

/// Disturbance r and its information N of everything after a moment.
template <int K>
struct Disturbance {
  StateVector<K> r = StateVector<K>::Zero();
  StateMatrix<K> N = StateMatrix<K>::Zero();

  void add(const LinearNumber<K>& number) {
    const Eigen::Matrix<double, 1, 5 + K> future = (number.gain.transpose() * N).eval();
    const double precision = 1.0 / number.innovation_variance;
    const double surprise = number.innovation * precision - number.gain.dot(r);
    r += number.H.transpose() * surprise;
    // (I - KH)' N (I - KH) + H'H/S, written as updates of rank 1 and 2
    const double scale = (future * number.gain).value() + number.pull_variance;
    N += scale * number.H.transpose() * number.H - number.H.transpose() * future -
         future.transpose() * number.H;
  }

  void passMotion(const LinearMotion<K>& motion) {
    const Eigen::Matrix2d& R = motion.R_end_start;
    if constexpr (K > 0) {
      r.template tail<K>() += motion.J_light_errors.transpose() * r.template head<2>();
      N.template bottomRows<K>() += motion.J_light_errors.transpose() * N.template topRows<2>();
      N.template rightCols<K>() += N.template leftCols<2>() * motion.J_light_errors;
    }
    r.template head<2>() = (R.transpose() * r.template head<2>()).eval();
    N.template topRows<2>() = (R.transpose() * N.template topRows<2>()).eval();
    N.template leftCols<2>() = (N.template leftCols<2>() * R).eval();
  }

  /// What an unknown jump of the light at this moment would take off the cost. Only those of its
  /// directions count in which the other sights tell a jump that is small against the light's
  /// range: in the others a gain is an accident of the linearisation.
  double slipGain(double range_m) const {
    constexpr double kTellable = 0.2;  // standard deviation of the jump, over the range
    const double least_information = 1.0 / std::pow(kTellable * range_m, 2);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
    solver.computeDirect(Eigen::Matrix2d(N.template topLeftCorner<2, 2>()));
    double gain = 0.0;
    for (int i = 0; i < 2; ++i) {
      const double information = solver.eigenvalues()(i);
      if (information < least_information) continue;
      gain += std::pow(solver.eigenvectors().col(i).dot(r.template head<2>()), 2) / information;
    }
    return gain;
  }
};

/// Fills in the residual of a bearing against the state smoothed from all others.
template <int K>
void leaveOut(const ForwardStep<K>& step, double variance, const Disturbance<K>& future,
              SmoothedSight& smoothed) {
  const LinearNumber<K>& azimuth = step.azimuth;
  if (step.used) {
    const double precision =
        1.0 / azimuth.innovation_variance + azimuth.gain.dot(future.N * azimuth.gain);
    smoothed.left_out_residual_rad =
        (azimuth.innovation / azimuth.innovation_variance - azimuth.gain.dot(future.r)) / precision;
    smoothed.left_out_variance_rad2 = std::max(1.0 / precision - variance, 0.0);
    return;
  }
  const StateVector<K> PHt = step.predicted_covariance * azimuth.H.transpose();
  smoothed.left_out_residual_rad = azimuth.innovation - PHt.dot(future.r);
  smoothed.left_out_variance_rad2 =
      std::max((azimuth.H * PHt).value() - PHt.dot(future.N * PHt), 0.0);
}

/// One pass over a record with the first K errors in the state.
template <int K>
class Smoother {
 public:
  Smoother(const std::vector<Sight>& sights, const std::vector<SightWeight>& weights,
           const RecordPath& path)
      : sights_(sights), weights_(weights), path_(path) {
    steps_.reserve(sights.size());
    motions_.reserve(sights.size());
    pass_.sights.resize(sights.size());
  }

  SmootherPass run(const SmootherPrior& prior, const ErrorPriors& errors) {
    goForward(prior, errors);
    goBackward();
    return std::move(pass_);
  }

 private:
  void goForward(const SmootherPrior& prior, const ErrorPriors& errors);
  void goBackward();
  void addElevation(std::size_t i, StateVector<K>& mean, StateMatrix<K>& covariance);

  const std::vector<Sight>& sights_;
  const std::vector<SightWeight>& weights_;
  const RecordPath& path_;
  std::vector<ForwardStep<K>> steps_;
  std::vector<std::optional<LinearNumber<K>>> elevations_;  ///< of each sight; empty without tilt
  std::vector<LinearMotion<K>> motions_;
  SmootherPass pass_;
};

template <int K>
void takeIn(const LinearNumber<K>& number, StateVector<K>& mean, StateMatrix<K>& covariance) {
  mean += number.gain * number.innovation;
  covariance -= number.gain * number.innovation_variance * number.gain.transpose();
}

template <int K>
void Smoother<K>::addElevation(std::size_t i, StateVector<K>& mean, StateMatrix<K>& covariance) {
  if constexpr (K == kErrorCount) {
    elevations_.emplace_back();
    if (!sights_[i].elevation || !weights_[i].use_bearing) return;
    const LinearNumber<K> number =
        lineariseElevation(sights_[i], weights_[i].elevation_doubt, path_.points[i].state,
                           path_.errors, mean, covariance);
    takeIn<K>(number, mean, covariance);
    pass_.sights[i].elevation = {number.innovation, number.innovation_variance};
    elevations_.back() = number;
  }
}

template <int K>
void Smoother<K>::goForward(const SmootherPrior& prior, const ErrorPriors& errors) {
  const Eigen::Matrix<double, K, 1> errors_at_path = path_.errors.head<K>();
  StateVector<K> mean = StateVector<K>::Zero();
  mean.template head<5>() = path_.points.front().state;
  StateVector<K> variance;
  variance.template head<4>().setConstant(prior.position_stddev_m * prior.position_stddev_m);
  variance(CartesianIndex::kSensorYaw) = prior.yaw_stddev_rad * prior.yaw_stddev_rad;
  mean.template tail<K>() = errors.mean.head<K>();
  variance.template tail<K>() = errors.stddev.head<K>().cwiseAbs2();
  StateMatrix<K> covariance = variance.asDiagonal();
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    const PathPoint& point = path_.points[i];
    motions_.push_back(lineariseMotion<K>(sights_[i], weights_[i].slipped, point, path_.errors));
    if (i > 0) predict<K>(motions_[i], point.motion_error, errors_at_path, mean, covariance);
    steps_.push_back(
        lineariseSight<K>(sights_[i], weights_[i], point.state, path_.errors, mean, covariance));
    const ForwardStep<K>& step = steps_.back();
    pass_.sights[i].innovation_rad = step.azimuth.innovation;
    pass_.sights[i].innovation_variance_rad2 = step.azimuth.innovation_variance;
    if (step.used) takeIn<K>(step.azimuth, mean, covariance);
    addElevation(i, mean, covariance);
  }
  pass_.last = RobotEstimate::from<K>({mean, 0.5 * (covariance + covariance.transpose())});
}

template <int K>
void Smoother<K>::goBackward() {
  Disturbance<K> future;
  for (std::size_t i = sights_.size(); i-- > 0;) {
    SmoothedSight& smoothed = pass_.sights[i];
    const ForwardStep<K>& step = steps_[i];
    if (!elevations_.empty() && elevations_[i]) future.add(*elevations_[i]);
    leaveOut<K>(step, weights_[i].bearing_variance_rad2, future, smoothed);
    if (step.used) future.add(step.azimuth);
    smoothed.point.state = step.predicted.template head<5>() +
                           step.predicted_covariance.template topRows<5>() * future.r;
    if (i == 0) break;
    smoothed.mount_jump = {
        future.r.template segment<3>(CartesianIndex::kSensorX),
        future.N.template block<3, 3>(CartesianIndex::kSensorX, CartesianIndex::kSensorX)};
    smoothed.slip_gain =
        weights_[i].slipped ? 0.0 : future.slipGain(rangeOf(path_.points[i].state));
    const Eigen::Vector3d pull =
        motions_[i].J_light_error.transpose() * future.r.template head<2>();
    smoothed.point.motion_error = motions_[i].covariance * pull;
    pass_.motion_cost += pull.dot(smoothed.point.motion_error);
    future.passMotion(motions_[i]);
  }
}

}  // namespace

Eigen::Matrix3d slipCovariance() {
  constexpr double kPositionStddev_m = 0.3;
  constexpr double kYawStddev_rad = 0.5;
  return Eigen::Vector3d(kPositionStddev_m, kPositionStddev_m, kYawStddev_rad)
      .cwiseAbs2()
      .asDiagonal();
}

SmootherPass smooth(const std::vector<Sight>& sights, const std::vector<SightWeight>& weights,
                    const RecordPath& path, const SmootherPrior& prior, const ErrorPriors& errors) {
  return withErrorsInUse(errorsInUse(errors), [&](auto size) {
    return Smoother<size.value>(sights, weights, path).run(prior, errors);
  });
}

}  // namespace bearing_calibration
