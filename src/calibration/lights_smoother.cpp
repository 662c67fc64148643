#include "bearing_calibration/calibration/lights_smoother.h"

#include <algorithm>

#include "bearing_calibration/calibration/cartesian_smoother.h"

namespace bearing_calibration {
namespace {

/// One image of the forward pass, as the backward one needs it.
struct ForwardImage {
  LightsMotion motion;
  std::size_t first_update = 0;  ///< of this image, among all
};

class LightsSmoother {
 public:
  LightsSmoother(const std::vector<LightsImage>& images, const LightsWeights& weights,
                 const LightsLayout& layout, const LightsPath& path)
      : images_(images), weights_(weights), layout_(layout), path_(path) {
    forward_.reserve(images.size());
    updates_.reserve(images.size() * static_cast<std::size_t>(layout.lights));
  }

  LightsPass run(const ErrorPriors& errors) {
    goForward(errors);
    goBackward();
    return std::move(pass_);
  }

 private:
  LightsEstimate nothingKnown(const ErrorPriors& errors) const;
  void move(std::size_t i, LightsEstimate* estimate);
  void goForward(const ErrorPriors& errors);
  void goBackward();

  const std::vector<LightsImage>& images_;
  const LightsWeights& weights_;
  const LightsLayout layout_;
  const LightsPath& path_;
  std::vector<ForwardImage> forward_;
  std::vector<LightsUpdate> updates_;
  LightsPass pass_;
};

LightsEstimate LightsSmoother::nothingKnown(const ErrorPriors& errors) const {
  const double position_variance = kFreePass.position_stddev_m * kFreePass.position_stddev_m;
  LightsVector variance = LightsVector::Constant(layout_.size(), position_variance);
  variance(kMountSize - 1) = kFreePass.yaw_stddev_rad * kFreePass.yaw_stddev_rad;
  variance.segment(kMountSize, layout_.errors) = errors.stddev.head(layout_.errors).cwiseAbs2();
  // What a prior says of the robot's errors is that they are zero, wherever the path has them.
  LightsVector mean = path_.states.front();
  mean.segment(kMountSize, layout_.errors).setZero();
  return {layout_, mean, variance.asDiagonal()};
}

void LightsSmoother::move(std::size_t i, LightsEstimate* estimate) {
  const std::size_t before = i > 0 ? i - 1 : 0;
  LightsMotion motion =
      lineariseMotion(layout_, path_.states[before], images_[i].motion, path_.motion_errors[i]);
  if (weights_.images[i].slipped) motion.covariance += slipCovariance();
  forward_.push_back({motion, updates_.size()});
  if (i > 0) propagate(motion, estimate);
}

void LightsSmoother::goForward(const ErrorPriors& errors) {
  LightsEstimate estimate = nothingKnown(errors);
  for (std::size_t i = 0; i < images_.size(); ++i) {
    move(i, &estimate);
    for (int light = 0; light < layout_.lights; ++light) {
      const auto at = static_cast<std::size_t>(light);
      const LightSight& sight = images_[i].lights[at];
      if (!sight.isSeen() || !weights_.images[i].use[at]) continue;
      updates_.push_back(updateByAzimuth(path_.states[i], light, sight.azimuth_rad,
                                         weights_.widening[at] * sight.azimuth_variance_rad2,
                                         images_[i].nearby, &estimate));
      pass_.chi_square += updates_.back().nis();
    }
  }
  pass_.bearings = static_cast<int>(updates_.size());
  pass_.last = estimate;
  pass_.last.covariance = (0.5 * (estimate.covariance + estimate.covariance.transpose())).eval();
}

void LightsSmoother::goBackward() {
  const int lights_at = layout_.lightsAt();
  const int lights_size = 2 * layout_.lights;
  LightsVector r = LightsVector::Zero(layout_.size());
  pass_.motion_errors.assign(images_.size(), Eigen::Vector3d::Zero());
  std::size_t next = updates_.size();
  for (std::size_t i = images_.size(); i-- > 1;) {
    while (next > forward_[i].first_update) {
      const LightsUpdate& update = updates_[--next];
      r += update.H.transpose() *
           (update.innovation / update.innovation_variance - update.gain.dot(r));
    }
    const LightsMotion& motion = forward_[i].motion;
    const LightsVector pull = r.segment(lights_at, lights_size);
    pass_.motion_errors[i] = motion.covariance * (motion.J_lights_error.transpose() * pull);
    r.segment(kMountSize, layout_.errors) += motion.J_lights_errors.transpose() * pull;
    for (int light = 0; light < layout_.lights; ++light) {
      r.segment<2>(layout_.lightAt(light)) =
          motion.R_end_start.transpose() * pull.segment<2>(2 * light);
    }
  }
}

}  // namespace

LightsPath pathTo(const LightsLayout& layout, const LightsVector& last,
                  const std::vector<LightsImage>& images,
                  const std::vector<Eigen::Vector3d>& motion_errors) {
  LightsPath path{std::vector<LightsVector>(images.size(), last), motion_errors};
  const ErrorVector errors = errorsOf(layout, last);
  for (std::size_t i = images.size(); i-- > 1;) {
    Pose2 start_from_end = correctMotion<kErrorCount>(images[i].motion, errors).start_from_end;
    start_from_end.position_m += motion_errors[i].head<2>();
    start_from_end.yaw_rad = wrapAngle(start_from_end.yaw_rad + motion_errors[i].z());
    for (int light = 0; light < layout.lights; ++light) {
      const int at = layout.lightAt(light);
      path.states[i - 1].segment<2>(at) =
          start_from_end * Eigen::Vector2d(path.states[i].segment<2>(at));
    }
  }
  return path;
}

LightsPass smoothLights(const std::vector<LightsImage>& images, const LightsWeights& weights,
                        const LightsLayout& layout, const LightsPath& path,
                        const ErrorPriors& errors) {
  return LightsSmoother(images, weights, layout, path).run(errors);
}

}  // namespace bearing_calibration
