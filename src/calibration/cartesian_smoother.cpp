#include "bearing_calibration/calibration/cartesian_smoother.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration {
namespace {

using RowVector5 = Eigen::Matrix<double, 1, 5>;

/// What a slipping wheel may do between two sights: wider than any slip, so that nothing of the
/// motion is believed.
constexpr double kSlipPositionStddev_m = 0.3;
constexpr double kSlipYawStddev_rad = 0.5;

/// Variance of Huber's bounded pull over that of an ordinary bearing's, for a sight that is mostly
/// doubted: its square at 2 standard deviations where a fifth of all sights are outliers.
constexpr double kDoubtfulPull = 1.6;

/// What the backward pass needs from the forward one.
struct ForwardStep {
  Vector5 predicted;
  Matrix5 predicted_covariance;
  RowVector5 H;
  Vector5 gain;
  double innovation;  ///< against `predicted`, through the linearisation at the path
  double innovation_variance;
  double pull_variance;  ///< of innovation / innovation_variance
  bool used;
};

/// A motion linearised about its own error: l+ = F (l - t) + J (error - error*).
struct LinearMotion {
  Pose2 start_from_end;  ///< the measured one with its error* put right
  Eigen::Matrix<double, 2, 3> J_light_error;
  Eigen::Matrix3d covariance;  ///< of the error

  Eigen::Matrix2d rotation() const { return rotation2(-start_from_end.yaw_rad); }
  Eigen::Matrix2d lightNoise() const {
    return J_light_error * covariance * J_light_error.transpose();
  }
};

LinearMotion linearise(const Sight& sight, bool slipped, const PathPoint& point) {
  const Pose2& measured = sight.motion.start_from_end;
  LinearMotion motion;
  motion.start_from_end = {measured.position_m + point.motion_error.head<2>(),
                           wrapAngle(measured.yaw_rad + point.motion_error(2))};
  motion.J_light_error << -motion.rotation(),
      -perpendicular(Eigen::Vector2d(point.state.head<2>()));
  motion.covariance = sight.motion.covariance;
  if (slipped) {
    motion.covariance.diagonal() +=
        Eigen::Vector3d(kSlipPositionStddev_m, kSlipPositionStddev_m, kSlipYawStddev_rad)
            .cwiseAbs2();
  }
  return motion;
}

void predict(const LinearMotion& motion, const Eigen::Vector3d& error, Vector5& mean,
             Matrix5& covariance) {
  const Eigen::Matrix2d F = motion.rotation();
  mean.head<2>() = motion.start_from_end.inverse() * Eigen::Vector2d(mean.head<2>()) -
                   motion.J_light_error * error;
  covariance.topRows<2>() = (F * covariance.topRows<2>()).eval();
  covariance.leftCols<2>() = (covariance.leftCols<2>() * F.transpose()).eval();
  covariance.topLeftCorner<2, 2>() += motion.lightNoise();
}

ForwardStep linearise(const Sight& sight, const SightWeight& weight, const Vector5& path,
                      const Vector5& mean, const Matrix5& covariance) {
  const AzimuthModel expected = azimuthFromCartesian(path);
  ForwardStep step;
  step.predicted = mean;
  step.predicted_covariance = covariance;
  step.H = expected.J_azimuth_state;
  step.innovation =
      wrapAngle(sight.azimuth_rad - expected.azimuth_rad) - (step.H * (mean - path)).value();
  const Vector5 PHt = covariance * step.H.transpose();
  step.innovation_variance = (step.H * PHt).value() + weight.bearing_variance_rad2;
  step.pull_variance = 1.0 / step.innovation_variance;
  if (weight.bearing_variance_rad2 > weight.sensor_variance_rad2) {
    // The pull of a doubtful bearing is bounded by its weight, but it is not as small as a bearing
    // of so large a variance would have it: else a few outliers look like a slip.
    step.pull_variance = kDoubtfulPull / ((step.H * PHt).value() + weight.sensor_variance_rad2);
  }
  step.gain = PHt / step.innovation_variance;
  step.used = weight.use_bearing;
  return step;
}

double rangeOf(const Vector5& state) {
  return (state.head<2>() - state.segment<2>(CartesianIndex::kSensorX)).norm();
}

/// Disturbance r and its information N of everything after a moment.
struct Disturbance {
  Vector5 r = Vector5::Zero();
  Matrix5 N = Matrix5::Zero();

  void addBearing(const ForwardStep& step) {
    const RowVector5 future = (step.gain.transpose() * N).eval();
    const double precision = 1.0 / step.innovation_variance;
    const double surprise = step.innovation * precision - step.gain.dot(r);
    r += step.H.transpose() * surprise;
    // (I - KH)' N (I - KH) + H'H/S, written as updates of rank 1 and 2
    const double scale = (future * step.gain).value() + step.pull_variance;
    N += scale * step.H.transpose() * step.H - step.H.transpose() * future -
         future.transpose() * step.H;
  }

  void passMotion(const LinearMotion& motion) {
    const Eigen::Matrix2d F = motion.rotation();
    r.head<2>() = (F.transpose() * r.head<2>()).eval();
    N.topRows<2>() = (F.transpose() * N.topRows<2>()).eval();
    N.leftCols<2>() = (N.leftCols<2>() * F).eval();
  }

  /// What an unknown jump of the light at this moment would take off the cost. Only those of its
  /// directions count in which the other sights tell a jump that is small against the light's
  /// range: in the others a gain is an accident of the linearisation.
  double slipGain(double range_m) const {
    constexpr double kTellable = 0.2;  // standard deviation of the jump, over the range
    const double least_information = 1.0 / std::pow(kTellable * range_m, 2);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
    solver.computeDirect(N.topLeftCorner<2, 2>());
    double gain = 0.0;
    for (int i = 0; i < 2; ++i) {
      const double information = solver.eigenvalues()(i);
      if (information < least_information) continue;
      gain += std::pow(solver.eigenvectors().col(i).dot(r.head<2>()), 2) / information;
    }
    return gain;
  }
};

/// Fills in the residual of a bearing against the state smoothed from all others.
void leaveOut(const ForwardStep& step, double variance, const Disturbance& future,
              SmoothedSight& smoothed) {
  if (step.used) {
    const double precision = 1.0 / step.innovation_variance + step.gain.dot(future.N * step.gain);
    smoothed.left_out_residual_rad =
        (step.innovation / step.innovation_variance - step.gain.dot(future.r)) / precision;
    smoothed.left_out_variance_rad2 = std::max(1.0 / precision - variance, 0.0);
    return;
  }
  const Vector5 PHt = step.predicted_covariance * step.H.transpose();
  smoothed.left_out_residual_rad = step.innovation - PHt.dot(future.r);
  smoothed.left_out_variance_rad2 = std::max((step.H * PHt).value() - PHt.dot(future.N * PHt), 0.0);
}

}  // namespace

SmootherPass smooth(const std::vector<Sight>& sights, const std::vector<SightWeight>& weights,
                    const std::vector<PathPoint>& path, const SmootherPrior& prior) {
  const std::size_t n = sights.size();
  SmootherPass pass;
  pass.sights.resize(n);
  std::vector<ForwardStep> steps;
  std::vector<LinearMotion> motions;
  steps.reserve(n);
  motions.reserve(n);

  Vector5 mean = path.front().state;
  Matrix5 covariance = Matrix5::Zero();
  covariance.diagonal().setConstant(prior.position_stddev_m * prior.position_stddev_m);
  covariance(4, 4) = prior.yaw_stddev_rad * prior.yaw_stddev_rad;
  for (std::size_t i = 0; i < n; ++i) {
    motions.push_back(linearise(sights[i], weights[i].slipped, path[i]));
    if (i > 0) predict(motions[i], path[i].motion_error, mean, covariance);
    steps.push_back(linearise(sights[i], weights[i], path[i].state, mean, covariance));
    const ForwardStep& step = steps.back();
    pass.sights[i].innovation_rad = step.innovation;
    pass.sights[i].innovation_variance_rad2 = step.innovation_variance;
    if (!step.used) continue;
    mean += step.gain * step.innovation;
    covariance -= step.gain * step.innovation_variance * step.gain.transpose();
  }
  pass.last = {mean, 0.5 * (covariance + covariance.transpose())};

  Disturbance future;
  for (std::size_t i = n; i-- > 0;) {
    SmoothedSight& smoothed = pass.sights[i];
    leaveOut(steps[i], weights[i].bearing_variance_rad2, future, smoothed);
    if (steps[i].used) future.addBearing(steps[i]);
    smoothed.point.state = steps[i].predicted + steps[i].predicted_covariance * future.r;
    if (i == 0) break;
    smoothed.mount_jump = {future.r.tail<3>(), future.N.bottomRightCorner<3, 3>()};
    smoothed.slip_gain = weights[i].slipped ? 0.0 : future.slipGain(rangeOf(path[i].state));
    const Eigen::Vector3d pull = motions[i].J_light_error.transpose() * future.r.head<2>();
    smoothed.point.motion_error = motions[i].covariance * pull;
    pass.motion_cost += pull.dot(smoothed.point.motion_error);
    future.passMotion(motions[i]);
  }
  return pass;
}

}  // namespace bearing_calibration
