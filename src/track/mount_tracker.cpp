#include "bearing_calibration/track/mount_tracker.h"

#include <bitset>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {
namespace {

constexpr double kLostBelowFusedShare = 0.3;
constexpr int kGatedBeforeRecovery = 5;  // in a row
constexpr int kLostWindow = RecentInnovations::kWindow / 2;

}  // namespace

void FilterConfig::declare(Parameters& params) {
  constexpr double kSmallestGate = 0.5;
  constexpr double kLargestGate = 0.999999999;
  params.choice("filter/parametrisation", {"cartesian", "paper"}, parametrisation);
  params.number("filter/gate_probability", gate_probability, kSmallestGate, kLargestGate);
}

CartesianEstimate placeLight(const MountEstimate& base_from_sensor, const LightDistance& distance,
                             double azimuth_rad, double azimuth_variance_rad2) {
  const Eigen::Vector2d sensor = base_from_sensor.mean.head<2>();
  const double yaw = base_from_sensor.mean.z();
  const Eigen::Vector2d direction = rotation2(yaw + azimuth_rad) * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d J_light_angle = distance.mean_m * perpendicular(direction);

  Eigen::Matrix<double, 5, 3> J_state_mount = Eigen::Matrix<double, 5, 3>::Zero();
  J_state_mount.topLeftCorner<2, 2>().setIdentity();
  J_state_mount.topRightCorner<5, 1>().head<2>() = J_light_angle;
  J_state_mount.bottomRows<3>().setIdentity();

  CartesianEstimate estimate;
  estimate.mean << sensor + distance.mean_m * direction, sensor, yaw;
  estimate.covariance = J_state_mount * base_from_sensor.covariance * J_state_mount.transpose();
  estimate.covariance.topLeftCorner<2, 2>() +=
      distance.stddev_m * distance.stddev_m * direction * direction.transpose() +
      azimuth_variance_rad2 * J_light_angle * J_light_angle.transpose();
  return estimate;
}

StateEstimate widenLight(StateEstimate estimate, double stddev_m, double stddev_rad) {
  const Eigen::Vector2d across = perpendicular(estimate.mean.tail<2>());
  estimate.covariance.bottomRightCorner<2, 2>() +=
      stddev_m * stddev_m * Eigen::Matrix2d::Identity() +
      stddev_rad * stddev_rad * across * across.transpose();
  return estimate;
}

Association FormerTrack::fuse(const std::vector<Bearing>& candidates, const OdometryWindow& nearby,
                              const FusionConfig& fusion, const Association& present) {
  constexpr double kVaguer = 4.0;  // variance of an expectation that says less
  ++images_;
  const Association association =
      associate(filter_.predictAzimuth(nearby), candidates, fusion.gate);
  const bool found = association.kind == Association::Kind::kFound;
  if (found) filter_.update(fusion.widened(candidates[association.candidate]), nearby);
  const bool expected_there_too =
      present.kind == Association::Kind::kFound && present.candidate == association.candidate &&
      present.innovation.variance < kVaguer * association.innovation.variance;
  found_ = found_ << 1U | static_cast<unsigned>(found && !expected_there_too);
  return association;
}

bool FormerTrack::isBack() const {
  constexpr unsigned kLookBack = 5;   // images
  constexpr std::size_t kFewest = 4;  // of these, which after a slip happens by chance once in 10^5
  constexpr unsigned kLast = 1U;
  constexpr unsigned kMask = (1U << kLookBack) - 1U;
  return (found_ & kLast) != 0 && std::bitset<kLookBack>(found_ & kMask).count() >= kFewest;
}

bool FormerTrack::isHistory() const {
  // Six seconds of another light at 10 Hz: more than the batch needs (record_track.cpp).
  constexpr int kPatience = 60;
  return images_ > kPatience;
}

MountTracker::MountTracker(const FilterConfig& config, const StateEstimate& start,
                           double bearing_correlation)
    : fusion_{chiSquareQuantile(config.gate_probability, 1.0), wideningFor(bearing_correlation)},
      filter_(start, config.parametrisation) {}

void MountTracker::move(const OdometryIncrement& motion) {
  OdometryIncrement known = motion;
  if (motion.isTurnUnknown()) {
    motion_unknown_ = true;
    known.covariance.setZero();  // the light is placed anew at the next look
  }
  filter_.predict(known);
  if (former_) former_->move(known);
}

Association MountTracker::fuse(const std::vector<Bearing>& candidates, const OdometryWindow& nearby,
                               bool may_be_others) {
  if (candidates.empty()) return {};
  if (motion_unknown_) return placeAnew(candidates, may_be_others);
  const Association association =
      associate(filter_.predictAzimuth(nearby), candidates, fusion_.gate);
  const bool is_found = association.kind == Association::Kind::kFound;
  if (is_found) filter_.update(fusion_.widened(candidates[association.candidate]), nearby);
  if (former_) {
    const Association found = former_->fuse(candidates, nearby, fusion_, association);
    if (former_->isBack()) {
      filter_ = former_->filter();
      former_.reset();
      noteFused(found);
      return found;
    }
    if (former_->isHistory()) former_.reset();
  }
  if (is_found) {
    noteFused(association);
    return association;
  }
  recent_.noteNotFused();
  if (!may_be_others && association.kind == Association::Kind::kGated &&
      ++gated_in_a_row_ >= kGatedBeforeRecovery) {
    gated_in_a_row_ = 0;
    lookAnew();
  }
  return association;
}

/// After an unknown turn the light may be in any direction: the only one that is seen is the light.
/// Of several nobody knows which: nothing is fused, until it has been so for too long.
Association MountTracker::placeAnew(const std::vector<Bearing>& candidates, bool may_be_others) {
  if (candidates.size() > 1 || may_be_others) {
    recent_.noteNotFused();
    if (!isLost()) return {};
    motion_unknown_ = false;  // in vain: it is not searched for any longer
    former_.reset();
    return {Association::Kind::kAmbiguous, 0, {}};
  }
  const Bearing& light = candidates.front();
  StateEstimate estimate = filter_.estimate();
  const double range = estimate.cartesian().range();
  estimate.setCartesian(placeLight(estimate.mount(), {range, range}, light.azimuth_rad,
                                   fusion_.widening * light.azimuth_variance_rad2));
  filter_.restart(estimate);
  motion_unknown_ = false;
  former_.reset();
  return {};
}

void MountTracker::noteFused(const Association& association) {
  gated_in_a_row_ = 0;
  recent_.noteFused(association.innovation.nis());
}

/// The light has been gated too often: it is looked for near and far.
void MountTracker::lookAnew() {
  constexpr double kRecoveryDistance_m = 0.03;  // in every direction
  constexpr double kRecoveryBearing_rad = radiansFromDegrees(10.0);
  if (!former_) former_.emplace(filter_);
  filter_.restart(widenLight(filter_.estimate(), kRecoveryDistance_m, kRecoveryBearing_rad));
}

void MountTracker::rebase(const StateEstimate& estimate, double bearing_correlation) {
  fusion_.widening = wideningFor(bearing_correlation);
  filter_.restart(estimate);
}

AzimuthPrediction MountTracker::predictAzimuthAfter(const OdometryIncrement& motion,
                                                    const OdometryWindow& nearby) const {
  LiveFilter after = filter_;
  after.predict(motion);
  return after.predictAzimuth(nearby);
}

bool MountTracker::isLost() const {
  const Consistency recent = consistency();
  const int images = recent.fused + recent.not_fused;
  return images >= kLostWindow && recent.fused < kLostBelowFusedShare * images;
}

}  // namespace bearing_calibration::core
