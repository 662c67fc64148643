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

/// A number as it is measured.
struct Measured {
  double residual;           ///< at the path
  double variance;           ///< larger than the ordinary one where it is doubted
  double ordinary_variance;  ///< what a sensor without doubt would have
};

LinearNumber linearise(const LightsRow& H, const Measured& measured, const LightsVector& path,
                       const LightsEstimate& estimate) {
  LinearNumber number;
  number.H = H.transpose();
  const LightsVector PHt = estimate.covariance * number.H;
  const double expected_variance = number.H.dot(PHt);
  number.innovation = measured.residual - number.H.dot(estimate.mean - path);
  number.innovation_variance = expected_variance + measured.variance;
  number.pull_variance = 1.0 / number.innovation_variance;
  if (measured.variance > measured.ordinary_variance) {
    // The pull of a doubtful bearing is bounded by its weight, but it is not as small as a bearing
    // of so large a variance would have it: else a few outliers look like a slip.
    number.pull_variance = kDoubtfulPull / (expected_variance + measured.ordinary_variance);
  }
  number.gain = PHt / number.innovation_variance;
  return number;
}

void takeIn(const LinearNumber& number, LightsEstimate* estimate) {
  estimate->mean += number.gain * number.innovation;
  const LightsVector scaled = number.innovation_variance * number.gain;
  estimate->covariance.noalias() -= number.gain * scaled.transpose();
}

/// What the backward pass needs of an image from the forward one.
struct ForwardImage {
  std::size_t first_observation;
  LightsMotion motion;     ///< to this image
  LightsVector predicted;  ///< mean of the lights before the image is taken in, ...
  LightsRows covariance;   ///< ... and their rows of the covariance
};

/// What an observation's numbers became on the way forward.
struct ForwardObservation {
  LinearNumber azimuth;
  std::optional<LinearNumber> elevation;
};

/// Fills in the residual of a bearing against the state smoothed from all others.
/// @param r_gain  the disturbance r times the azimuth's gain
/// @param N_gain  its information N between that gain and itself
void leaveOut(const LinearNumber& azimuth, const ObservationWeight& weight, double r_gain,
              double N_gain, SmoothedObservation* smoothed) {
  const double variance = weight.bearing_variance_rad2;
  const double S = azimuth.innovation_variance;
  if (weight.use_bearing) {
    const double precision = 1.0 / S + N_gain;
    smoothed->left_out_residual_rad = (azimuth.innovation / S - r_gain) / precision;
    smoothed->left_out_variance_rad2 = std::max(1.0 / precision - variance, 0.0);
    return;
  }
  smoothed->left_out_residual_rad = azimuth.innovation - S * r_gain;
  smoothed->left_out_variance_rad2 = std::max(S - variance - S * S * N_gain, 0.0);
}

/// One pass over a record.
class Smoother {
 public:
  Smoother(const std::vector<Observation>& observations,
           const std::vector<ObservationWeight>& weights, const RecordPath& path,
           const ErrorPriors& errors, const LightsEstimate* beginning)
      : observations_(observations),
        weights_(weights),
        path_(path),
        errors_(errors),
        beginning_(beginning),
        layout_{errorsInUse(errors), path.lights()},
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
  void enterImage(std::size_t i, LightsEstimate* estimate);
  void takeObservation(std::size_t i, LightsEstimate* estimate);
  void goForward(const SmootherPrior& prior);
  void leaveImage(std::size_t end, Disturbance* future);
  void goBackward();

  const std::vector<Observation>& observations_;
  const std::vector<ObservationWeight>& weights_;
  const RecordPath& path_;
  const ErrorPriors& errors_;
  const LightsEstimate* beginning_;
  const LightsLayout layout_;
  const bool takes_elevations_;
  std::vector<ForwardImage> images_;
  std::vector<ForwardObservation> forward_;  ///< of each observation
  SmootherPass pass_;
};

void Smoother::enterImage(std::size_t i, LightsEstimate* estimate) {
  const PathPoint& point = path_.points[i];
  LightsMotion motion = lineariseMotion(layout_, path_.errors, point.lights_in_base,
                                        observations_[i].motion, point.motion_error);
  if (weights_[i].slipped) motion.covariance += slipCovariance();
  if (hasMotion(i)) propagate(motion, estimate);
  const int size = 2 * layout_.lights;
  images_.push_back({i, motion, estimate->mean.tail(size), estimate->covariance.bottomRows(size)});
}

void Smoother::takeObservation(std::size_t i, LightsEstimate* estimate) {
  const Observation& observation = observations_[i];
  const ObservationWeight& weight = weights_[i];
  const LightsVector path = path_.lightsState(layout_, i);
  const LightsAngle expected = expectAzimuth(layout_, path, observation.light, observation.nearby);
  const Measured azimuth{wrapAngle(observation.azimuth_rad - expected.angle_rad),
                         weight.bearing_variance_rad2, weight.sensor_variance_rad2};
  forward_.push_back({linearise(expected.J_angle_state, azimuth, path, *estimate), std::nullopt});
  ForwardObservation& forward = forward_.back();
  SmoothedObservation& smoothed = pass_.observations[i];
  smoothed.innovation_rad = forward.azimuth.innovation;
  smoothed.innovation_variance_rad2 = forward.azimuth.innovation_variance;
  if (!weight.use_bearing) return;
  takeIn(forward.azimuth, estimate);
  if (!takes_elevations_ || !observation.elevation) return;
  const LightsAngle over = expectElevation(layout_, path, observation.light, observation.nearby);
  const double variance = observation.elevation->variance_rad2;
  const Measured elevation{observation.elevation->angle_rad - over.angle_rad,
                           weight.elevation_doubt * variance, variance};
  forward.elevation = linearise(over.J_angle_state, elevation, path, *estimate);
  smoothed.elevation = {forward.elevation->innovation, forward.elevation->innovation_variance};
  takeIn(*forward.elevation, estimate);
}

void Smoother::goForward(const SmootherPrior& prior) {
  LightsEstimate estimate = knownBeforehand(layout_, path_, prior, errors_, beginning_);
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    if (beginsImage(observations_, i)) enterImage(i, &estimate);
    takeObservation(i, &estimate);
  }
  pass_.last = std::move(estimate);
  symmetrise(&pass_.last.covariance);
}

/// Goes back over the motion to an image, of which all observations have been passed.
/// @param end  behind its last observation
void Smoother::leaveImage(std::size_t end, Disturbance* future) {
  const ForwardImage& image = images_.back();
  const std::size_t first = image.first_observation;
  PathPoint point;
  const LightsVector lights = image.predicted + image.covariance * future->r();
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
    if (elevation) future.add(*elevation, future.N() * elevation->gain);
    const LightsVector N_gain = future.N() * azimuth.gain;
    leaveOut(azimuth, weights_[i], azimuth.gain.dot(future.r()), azimuth.gain.dot(N_gain),
             &smoothed);
    if (weights_[i].use_bearing) future.add(azimuth, N_gain);
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
  pass_.path.errors = errorsOf(layout_, pass_.last.mean);
}

}  // namespace

bool beginsImage(const std::vector<Observation>& observations, std::size_t i) {
  return i == 0 || observations[i].stamp != observations[i - 1].stamp ||
         observations[i].light <= observations[i - 1].light;
}

Vector5 RecordPath::state(std::size_t observation, int light) const {
  Vector5 state;
  state << points[observation].lights_in_base.col(light), mount;
  return state;
}

LightsVector RecordPath::lightsState(const LightsLayout& layout, std::size_t observation) const {
  LightsVector state(layout.size());
  state << mount, errors.head(layout.errors), points[observation].lights_in_base.reshaped();
  return state;
}

LightsEstimate knownBeforehand(const LightsLayout& layout, const RecordPath& path,
                               const SmootherPrior& prior, const ErrorPriors& errors,
                               const LightsEstimate* beginning) {
  if (beginning != nullptr) {
    LightsEstimate known = *beginning;
    double& yaw = known.mean(kMountSize - 1);  // on the path's turn
    yaw = path.mount.z() + wrapAngle(yaw - path.mount.z());
    return known;
  }
  const int K = layout.errors;
  LightsVector variance =
      LightsVector::Constant(layout.size(), std::pow(prior.position_stddev_m, 2));
  variance(kMountSize - 1) = prior.yaw_stddev_rad * prior.yaw_stddev_rad;
  variance.segment(kMountSize, K) = errors.stddev.head(K).cwiseAbs2();
  LightsVector mean = path.lightsState(layout, 0);
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
                    const LightsEstimate* beginning) {
  return Smoother(observations, weights, path, errors, beginning).run(prior);
}

}  // namespace bearing_calibration::core
