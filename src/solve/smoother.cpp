#include "bearing_calibration/solve/smoother.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/solve/disturbance.h"

namespace bearing_calibration::core {
namespace {

/// Variance of Huber's bounded pull over that of an ordinary bearing's, for an observation that is
/// mostly doubted: its square at 2 standard deviations where a fifth of all observations are
/// outliers.
constexpr double kDoubtfulPull = 1.6;

/// Variance of the pull of a number that is taken in.
double pullVariance(const ScalarUpdate& update, double ordinary_variance) {
  if (!(update.variance > ordinary_variance)) return 1.0 / update.innovation.variance;
  // The pull of a doubtful bearing is bounded by its weight, but it is not as small as a bearing
  // of so large a variance would have it: else a few outliers look like a slip.
  const double expected_variance = update.innovation.variance - update.variance;
  return kDoubtfulPull / (expected_variance + ordinary_variance);
}

/// The lights' own rows of a covariance.
using LightRows =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMostLights, kMostState>;

/// What the backward pass needs of an image from the forward one.
struct ForwardImage {
  std::size_t first_observation;
  LinearMotion motion;    ///< to this image
  StateVector predicted;  ///< mean of the lights before the image is taken in, ...
  LightRows covariance;   ///< ... and their rows of the covariance
};

/// What an observation's numbers became on the way forward.
struct ForwardObservation {
  ScalarUpdate azimuth;
  std::optional<ScalarUpdate> elevation;
};

/// Fills in the residual of a bearing against the state smoothed from all others.
/// @param r_gain  the disturbance r times the azimuth's gain
/// @param N_gain  its information N between that gain and itself
void leaveOut(const ScalarUpdate& azimuth, bool is_used, double r_gain, double N_gain,
              SmoothedObservation* smoothed) {
  const auto& [residual, S] = azimuth.innovation;
  if (is_used) {
    const double precision = 1.0 / S + N_gain;
    smoothed->left_out_residual_rad = (residual / S - r_gain) / precision;
    smoothed->left_out_variance_rad2 = std::max(1.0 / precision - azimuth.variance, 0.0);
    return;
  }
  smoothed->left_out_residual_rad = residual - S * r_gain;
  smoothed->left_out_variance_rad2 = std::max(S - azimuth.variance - S * S * N_gain, 0.0);
}

/// One pass over a record.
class Smoother {
 public:
  Smoother(const std::vector<Observation>& observations,
           const std::vector<ObservationWeight>& weights, const RecordPath& path,
           const ErrorPriors& errors, const StateEstimate* beginning)
      : observations_(observations),
        weights_(weights),
        path_(path),
        errors_(errors),
        beginning_(beginning),
        layout_{errorsInUse(errors, path.lights()), path.lights()},
        takes_elevations_(errors.usesElevations()) {
    images_.reserve(observations.size());
    forward_.reserve(observations.size());
    pass_.observations.resize(observations.size());
    pass_.path.points.resize(observations.size());
  }

  SmootherPass run(const SmootherPrior& prior) {
    goForward(prior);
    goBackward();
    return std::move(pass_);
  }

 private:
  bool hasMotion(std::size_t i) const { return i > 0 || beginning_ != nullptr; }
  double elevationVariance(std::size_t i) const {  ///< of an ordinary one
    return weights_[i].elevation_widening * observations_[i].elevation->variance_rad2;
  }
  void enterImage(std::size_t i, StateEstimate* estimate);
  void takeObservation(std::size_t i, StateEstimate* estimate);
  void goForward(const SmootherPrior& prior);
  void leaveImage(std::size_t end, Disturbance* future);
  void goBackward();

  const std::vector<Observation>& observations_;
  const std::vector<ObservationWeight>& weights_;
  const RecordPath& path_;
  const ErrorPriors& errors_;
  const StateEstimate* beginning_;
  const StateLayout layout_;
  const bool takes_elevations_;
  std::vector<ForwardImage> images_;
  std::vector<ForwardObservation> forward_;  ///< of each observation
  SmootherPass pass_;
};

void Smoother::enterImage(std::size_t i, StateEstimate* estimate) {
  const PathPoint& point = path_.points[i];
  LinearMotion motion = lineariseMotion(layout_, path_.errors, point.lights_in_base,
                                        observations_[i].motion, point.motion_error);
  if (weights_[i].slipped) motion.covariance += slipCovariance();
  if (hasMotion(i)) propagate(motion, estimate);
  const int size = 2 * layout_.lights;
  images_.push_back({i, motion, estimate->mean.tail(size), estimate->covariance.bottomRows(size)});
}

void Smoother::takeObservation(std::size_t i, StateEstimate* estimate) {
  const Observation& observation = observations_[i];
  const ObservationWeight& weight = weights_[i];
  const StateVector path = path_.stateAt(layout_, i);
  const auto linearise = [&](const ExpectedAngle& expected, double measured_rad, double variance) {
    const StateRow& H = expected.J_angle_state;
    const double at_path_rad = wrapAngle(measured_rad - expected.angle_rad);
    return prepareUpdate(H, at_path_rad - H.dot((estimate->mean - path).transpose()), variance,
                         *estimate);
  };
  forward_.push_back({linearise(expectAzimuth(layout_, path, observation.light, observation.nearby),
                                observation.azimuth_rad, weight.bearing_variance_rad2),
                      std::nullopt});
  ForwardObservation& forward = forward_.back();
  SmoothedObservation& smoothed = pass_.observations[i];
  smoothed.azimuth = forward.azimuth.innovation;
  if (!weight.use_bearing) return;
  apply(forward.azimuth, estimate);
  if (!takes_elevations_ || !observation.elevation) return;
  forward.elevation =
      linearise(expectElevation(layout_, path, observation.light, observation.nearby),
                observation.elevation->angle_rad, weight.elevation_doubt * elevationVariance(i));
  smoothed.elevation = forward.elevation->innovation;
  apply(*forward.elevation, estimate);
}

void Smoother::goForward(const SmootherPrior& prior) {
  StateEstimate estimate = knownBeforehand(layout_, path_, prior, errors_, beginning_);
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    if (beginsImage(observations_, i)) enterImage(i, &estimate);
    takeObservation(i, &estimate);
  }
  pass_.last = std::move(estimate);
}

/// Goes back over the motion to an image, of which all observations have been passed.
/// @param end  behind its last observation
void Smoother::leaveImage(std::size_t end, Disturbance* future) {
  const ForwardImage& image = images_.back();
  const std::size_t first = image.first_observation;
  PathPoint point;
  const StateVector lights = image.predicted + image.covariance * future->r();
  point.lights_in_base = lights.reshaped(2, layout_.lights);
  if (hasMotion(first)) {
    if (first > 0 && !weights_[first].slipped) {
      const LightPositions& lights_at_path = path_.points[first].lights_in_base;
      double range_m2 = 0.0;
      for (int light = 0; light < layout_.lights; ++light) {
        range_m2 += (lights_at_path.col(light) - path_.mount.head<2>()).squaredNorm();
      }
      pass_.observations[first].slip_gain = future->slipGain(image.motion, range_m2);
    }
    const Eigen::Vector3d pull =
        image.motion.J_lights_error.transpose() * future->r().tail(2 * layout_.lights);
    point.motion_error = image.motion.covariance * pull;
    pass_.motion_cost += pull.dot(point.motion_error);
    future->passMotion(image.motion);
  }
  std::fill(pass_.path.points.begin() + static_cast<std::ptrdiff_t>(first),
            pass_.path.points.begin() + static_cast<std::ptrdiff_t>(end), point);
  images_.pop_back();
}

void Smoother::goBackward() {
  Disturbance future(layout_);
  std::size_t end = observations_.size();
  for (std::size_t i = observations_.size(); i-- > 0;) {
    SmoothedObservation& smoothed = pass_.observations[i];
    const auto& [azimuth, elevation] = forward_[i];
    if (elevation) {
      future.add(*elevation, pullVariance(*elevation, elevationVariance(i)),
                 future.N() * elevation->gain);
    }
    const StateVector N_gain = future.N() * azimuth.gain;
    const bool is_used = weights_[i].use_bearing;
    leaveOut(azimuth, is_used, azimuth.gain.dot(future.r()), azimuth.gain.dot(N_gain), &smoothed);
    if (is_used)
      future.add(azimuth, pullVariance(azimuth, weights_[i].sensor_variance_rad2), N_gain);
    smoothed.mount_displacement = {future.r().head<kMountSize>(),
                                   future.N().topLeftCorner<kMountSize, kMountSize>()};
    if (images_.back().first_observation < i) continue;
    leaveImage(end, &future);
    end = i;
  }
  if (beginning_ != nullptr) {
    pass_.beginning_cost = future.r().dot(beginning_->covariance * future.r());
  }
  pass_.path.mount = pass_.last.mean.head<kMountSize>();
  pass_.path.errors = robotErrorsOf(layout_, pass_.last.mean);
}

}  // namespace

bool beginsImage(const std::vector<Observation>& observations, std::size_t i) {
  return i == 0 || observations[i].stamp != observations[i - 1].stamp ||
         observations[i].light <= observations[i - 1].light;
}

double RecordPath::rangeAt(std::size_t observation, int light) const {
  return (points[observation].lights_in_base.col(light) - mount.head<2>()).norm();
}

Vector5 RecordPath::state(std::size_t observation, int light) const {
  Vector5 state;
  state << points[observation].lights_in_base.col(light), mount;
  return state;
}

StateVector RecordPath::stateAt(const StateLayout& layout, std::size_t observation) const {
  StateVector state(layout.size());
  state << mount, errors.head(layout.errors), points[observation].lights_in_base.reshaped();
  return state;
}

RecordPath RecordPath::towards(const RecordPath& other, double share) const {
  RecordPath between = *this;
  between.mount += share * (other.mount - mount);
  between.errors += share * (other.errors - errors);
  for (std::size_t i = 0; i < points.size(); ++i) {
    PathPoint& point = between.points[i];
    point.lights_in_base += share * (other.points[i].lights_in_base - points[i].lights_in_base);
    point.motion_error += share * (other.points[i].motion_error - points[i].motion_error);
  }
  return between;
}

StateEstimate knownBeforehand(const StateLayout& layout, const RecordPath& path,
                              const SmootherPrior& prior, const ErrorPriors& errors,
                              const StateEstimate* beginning) {
  if (beginning != nullptr) {
    StateEstimate known = *beginning;
    double& yaw = known.mean(kMountSize - 1);  // on the path's turn
    yaw = path.mount.z() + wrapAngle(yaw - path.mount.z());
    return known;
  }
  const int K = layout.errors;
  StateVector variance = StateVector::Constant(layout.size(), std::pow(prior.position_stddev_m, 2));
  variance(kMountSize - 1) = prior.yaw_stddev_rad * prior.yaw_stddev_rad;
  variance.segment(kMountSize, K) = errors.stddev.head(K).cwiseAbs2();
  StateVector mean = path.stateAt(layout, 0);
  mean.segment(kMountSize, K) = errors.mean.head(K);
  return {layout, mean, variance.asDiagonal()};
}

Eigen::Matrix3d slipCovariance() {
  constexpr double kPositionStddev_m = 0.3;
  constexpr double kYawStddev_rad = 0.5;
  return Eigen::Vector3d(kPositionStddev_m, kPositionStddev_m, kYawStddev_rad)
      .cwiseAbs2()
      .asDiagonal();
}

SmootherPass smooth(const std::vector<Observation>& observations,
                    const std::vector<ObservationWeight>& weights, const RecordPath& path,
                    const SmootherPrior& prior, const ErrorPriors& errors,
                    const StateEstimate* beginning) {
  return Smoother(observations, weights, path, errors, beginning).run(prior);
}

}  // namespace bearing_calibration::core
