#include "bearing_calibration/track/light_picker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

/// An only light nearer than this to where it was expected is the one that was seen before.
constexpr double kSameLight_rad = 0.35;
/// Largest NIS: of noise that is stated at half of what it is, 2.5 standard deviations.
constexpr double kGate = 25.0;
/// A light at this distance changes its azimuth by up to 1 rad/m.
constexpr double kNear_m = 1.0;
/// Of the sensor from the base's centre: so far it moves as the base turns by 1 rad.
constexpr double kLever_m = 0.3;
/// A light is followed from where no other is so near, as long as it is known so well where to
/// look.
constexpr double kApart_rad = 0.1;

/// The candidate of the highest probability; of several lights one that no other is near.
std::optional<std::size_t> likeliest(const std::vector<Bearing>& candidates, bool must_be_apart) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Bearing& light = candidates[i];
    if (best && !(light.overallProbability() > candidates[*best].overallProbability())) continue;
    const auto is_beside = [&light](const Bearing& other) {
      return &other != &light &&
             std::abs(wrapAngle(other.azimuth_rad - light.azimuth_rad)) < kApart_rad;
    };
    if (must_be_apart && std::any_of(candidates.begin(), candidates.end(), is_beside)) continue;
    best = i;
  }
  return best;
}

}  // namespace

void LightPicker::move(const OdometryIncrement& motion) {
  if (!direction_) return;
  const double way_m = motion.start_from_end.position_m.x();
  Eigen::Matrix2d F = Eigen::Matrix2d::Identity();
  F(0, 1) = way_m;
  direction_->mean = F * direction_->mean;
  direction_->mean.x() -= motion.start_from_end.yaw_rad;
  const double swing = kLever_m / kNear_m * motion.rotation_rad;
  const double change = (motion.rotation_rad + motion.distance_m / kNear_m) / kNear_m;
  direction_->covariance = F * direction_->covariance * F.transpose();
  direction_->covariance(0, 0) += motion.covariance(2, 2) + swing * swing;
  direction_->covariance(1, 1) += change * change;
}

Association LightPicker::pick(const std::vector<Bearing>& candidates, bool may_be_others) {
  const bool had_light = std::exchange(has_light_, false);
  if (candidates.empty()) return {};
  Association choice;
  if (direction_) {
    choice = associate({direction_->mean.x(), direction_->covariance(0, 0)}, candidates, kGate);
  }
  if (!direction_ || (choice.kind == Association::Kind::kGated && !may_be_others)) {
    choice = nearestOrLikeliest(choice, candidates, may_be_others);
  } else if (may_be_others && choice.kind == Association::Kind::kFound && !had_light && isLost()) {
    choice.kind = Association::Kind::kAmbiguous;
  }
  has_light_ = choice.kind == Association::Kind::kFound;
  if (has_light_) take(candidates[choice.candidate], choice.innovation);
  return choice;
}

Association LightPicker::nearestOrLikeliest(Association nearest,
                                            const std::vector<Bearing>& candidates,
                                            bool may_be_others) const {
  const bool is_near = direction_ && std::abs(nearest.innovation.residual) <= kSameLight_rad;
  if (!is_near) {
    const auto best = likeliest(candidates, may_be_others);
    if (!best) return {Association::Kind::kAmbiguous, 0, {}};
    nearest.candidate = *best;
  }
  nearest.kind = Association::Kind::kFound;
  return nearest;
}

void LightPicker::take(const Bearing& light, const Innovation& innovation) {
  const bool is_new = !direction_ || !(innovation.nis() <= kGate);
  if (is_new) {
    direction_ = Direction{{light.azimuth_rad, 0.0}, Eigen::Matrix2d::Zero()};
    direction_->covariance.diagonal() << light.azimuth_variance_rad2, 1.0 / (kNear_m * kNear_m);
    return;
  }
  const Eigen::Vector2d gain = direction_->covariance.col(0) / innovation.variance;
  direction_->mean += gain * innovation.residual;
  direction_->covariance -= innovation.variance * gain * gain.transpose();
}

bool LightPicker::isLost() const {
  return !has_light_ && direction_ && direction_->covariance(0, 0) > kApart_rad * kApart_rad;
}

}  // namespace bearing_calibration::core
