#include "bearing_calibration/vision/mirror_check.h"

#include <Eigen/LU>
#include <cmath>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

constexpr double kFalseAlarms = 1e-3;  // of checks of a centre that is right
// Focal length and distances are known to some percent; beyond, the horizon and the expected sizes
// are off by as much, and the gates that lean on them refuse lights.
constexpr double kRimTolerance = 0.03;

void checkCentre(const MirrorRim& rim, const DetectorConfig& config, MirrorCheck* check) {
  const Eigen::Vector2d configured(config.view.centre_u_px, config.view.centre_v_px);
  const Eigen::Vector2d departure = rim.circle.centre_px - configured;
  const Eigen::Matrix2d covariance =
      rim.covariance_px2.topLeftCorner<2, 2>() +
      std::pow(config.alignment.centre_stddev_px, 2) * Eigen::Matrix2d::Identity();
  const double distance2 = departure.dot(covariance.inverse() * departure);
  // Of two degrees of freedom, chi-square exceeds x with the probability exp(-x / 2).
  const bool fits = distance2 <= -2.0 * std::log(kFalseAlarms);
  check->consistent = check->consistent && fits;
  check->sentences.push_back(formatted(
      "the rim's centre is (%.2f +- %.2f, %.2f +- %.2f) px, mirror/centre_u and centre_v are "
      "(%.2f, %.2f): %s",
      rim.circle.centre_px.x(), rim.stddev(0), rim.circle.centre_px.y(), rim.stddev(1),
      configured.x(), configured.y(),
      fits ? "they agree" : "set them to the rim's centre, or raise alignment/centre_stddev"));
}

void checkRadius(const MirrorRim& rim, const DetectorConfig& config, MirrorCheck* check) {
  const double expected_px = rimRadiusPx(config.mirror);
  const double ratio = rim.circle.radius_px / expected_px;
  const bool fits = std::abs(ratio - 1.0) <= kRimTolerance;
  check->consistent = check->consistent && fits;
  check->sentences.push_back(
      formatted("the rim's radius is %.2f +- %.2f px, lens and mirror put it at %.2f px: %s",
                rim.circle.radius_px, rim.stddev(2), expected_px,
                fits ? "they agree"
                     : "check lens/focal_length, lens/focus_distance, lens/pixel_pitch, "
                       "mirror/lens_to_apex, mirror/half_angle and mirror/base_radius"));
}

void checkMask(const MirrorRim& rim, const DetectorConfig& config, MirrorCheck* check) {
  constexpr double kSlack_px = 1.0;  // a mask is cut at whole pixels
  const bool fits = config.mask.outer_radius_px <= rim.circle.radius_px + kSlack_px;
  if (fits) return;
  check->consistent = false;
  check->sentences.push_back(
      formatted("mask/outer_radius is %.1f px and reaches past the rim: set it to %.1f",
                config.mask.outer_radius_px, std::floor(rim.circle.radius_px)));
}

}  // namespace

MirrorCheck checkMirror(const MirrorRim& rim, const DetectorConfig& config) {
  MirrorCheck check;
  checkCentre(rim, config, &check);
  checkRadius(rim, config, &check);
  checkMask(rim, config, &check);
  return check;
}

}  // namespace bearing_calibration::core
