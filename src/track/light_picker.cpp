#include "bearing_calibration/track/light_picker.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

/// A light nearer than this to where it was expected is the same one: the change of direction that
/// the base's translation makes between two images is smaller.
constexpr double kSameLight_rad = 0.35;

}  // namespace

void LightPicker::move(const OdometryIncrement& motion) {
  if (expected_azimuth_rad_) *expected_azimuth_rad_ -= motion.start_from_end.yaw_rad;
}

std::optional<Bearing> LightPicker::pick(const std::vector<Bearing>& candidates) {
  if (candidates.empty()) return std::nullopt;
  const auto distance = [this](const Bearing& candidate) {
    return std::abs(wrapAngle(candidate.azimuth_rad - *expected_azimuth_rad_));
  };
  auto chosen = candidates.end();
  if (expected_azimuth_rad_) {
    chosen = std::min_element(
        candidates.begin(), candidates.end(),
        [&](const Bearing& a, const Bearing& b) { return distance(a) < distance(b); });
    if (distance(*chosen) > kSameLight_rad) chosen = candidates.end();
  }
  if (chosen == candidates.end()) {
    chosen = std::max_element(
        candidates.begin(), candidates.end(),
        [](const Bearing& a, const Bearing& b) { return a.probability < b.probability; });
  }
  expected_azimuth_rad_ = chosen->azimuth_rad;
  return *chosen;
}

}  // namespace bearing_calibration::core
