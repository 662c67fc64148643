#include "bearing_calibration/input/scan_bearings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/input/point_bearing.h"

namespace bearing_calibration::core {
namespace {

using RayIndex = std::size_t;

constexpr double kNoEcho_m = std::numeric_limits<double>::infinity();

/// Consecutive rays, and the sums over them.
struct RayRun {
  RayIndex first = 0;
  RayIndex end = 0;  ///< one behind the last
  double sum_of_ranges_m = 0.0;
  double sum_of_intensities = 0.0;
  double intensity_moment = 0.0;  ///< sum of intensity times index
  double most_intensity = 0.0;

  double rays() const { return static_cast<double>(end - first); }
  double range_m() const { return sum_of_ranges_m / rays(); }
};

/// A scan as it is segmented: by jumps of the range, or else by brightness.
class ScanSegments {
 public:
  ScanSegments(const LaserScan& scan, const ScanLightConfig& config)
      : scan_(scan), config_(config), by_jumps_(config.min_jump_m > 0.0) {}

  std::vector<RayRun> lights() const {
    std::vector<RayRun> found;
    const RayIndex count = scan_.ranges_m.size();
    for (RayIndex i = 0; i < count;) {
      const RayRun run = runFrom(i);
      if (run.first > 0 && run.end < count && run.end > run.first && isLight(run)) {
        found.push_back(run);
      }
      i = std::max(run.end, i + 1);
    }
    return found;
  }

  /// The middle of its edges, or the centre of its brightness, as an index.
  double middleOf(const RayRun& run) const {
    if (!by_jumps_) return run.intensity_moment / run.sum_of_intensities;
    return 0.5 * static_cast<double>(run.first + run.end - 1);
  }

 private:
  double range(RayIndex i) const {
    const auto range_m = static_cast<double>(scan_.ranges_m[i]);
    const bool is_echo = range_m >= scan_.least_range_m && range_m <= scan_.most_range_m;
    return is_echo && std::isfinite(range_m) ? range_m : kNoEcho_m;
  }
  double intensity(RayIndex i) const {
    const double value =
        config_.min_intensity > 0.0 ? static_cast<double>(scan_.intensities[i]) : 0.0;
    return std::isfinite(value) ? value : 0.0;
  }

  bool belongs(RayIndex i) const {
    return std::isfinite(range(i)) && (by_jumps_ || intensity(i) >= config_.min_intensity);
  }
  bool isApart(RayIndex i, RayIndex next) const {
    return by_jumps_ && std::abs(range(next) - range(i)) > config_.min_jump_m;
  }

  RayRun runFrom(RayIndex first) const {
    RayRun run;
    run.first = run.end = first;
    while (run.end < scan_.ranges_m.size() && belongs(run.end) &&
           (run.end == first || !isApart(run.end - 1, run.end))) {
      const double brightness = intensity(run.end);
      run.sum_of_ranges_m += range(run.end);
      run.sum_of_intensities += brightness;
      run.intensity_moment += brightness * static_cast<double>(run.end);
      run.most_intensity = std::max(run.most_intensity, brightness);
      ++run.end;
    }
    return run;
  }

  /// One that has rays before and behind it.
  bool isLight(const RayRun& run) const {
    const double jump_m =
        std::min(range(run.first - 1) - range(run.first), range(run.end) - range(run.end - 1));
    if (by_jumps_ && !(jump_m > config_.min_jump_m)) return false;
    if (run.most_intensity < config_.min_intensity) return false;
    // n rays hit what is n - 1 to n + 1 of their spacings wide.
    const double spacing_m = std::abs(scan_.ray_spacing_rad) * run.range_m();
    return (run.rays() + 1.0) * spacing_m >= config_.min_width_m &&
           (run.rays() - 1.0) * spacing_m <= config_.max_width_m;
  }

  const LaserScan& scan_;
  const ScanLightConfig& config_;
  bool by_jumps_;
};

}  // namespace

void ScanLightConfig::declare(Parameters& params) {
  constexpr double kBrightest = 1e6;  // scanners have 8 or 16 bits
  params.number("scan/min_intensity", min_intensity, 0.0, kBrightest);
  params.number("scan/min_jump", min_jump_m, 0.0, plausible::kFarthest_m);
  params.number("scan/min_width", min_width_m, 0.0, plausible::kFarthest_m);
  params.number("scan/max_width", max_width_m, plausible::kShortest_m, plausible::kFarthest_m);
  params.that(max_width_m > min_width_m, "scan/max_width must be greater than scan/min_width");
  params.that(min_intensity > 0.0 || min_jump_m > 0.0,
              "one of scan/min_intensity and scan/min_jump must be greater than 0");
}

std::string whyUnusable(const LaserScan& scan, const ScanLightConfig& config) {
  const double turn_rad =
      std::abs(scan.ray_spacing_rad) * static_cast<double>(scan.ranges_m.size());
  constexpr double kMostTurns = 1.1;  // some scanners see a few directions twice
  if (scan.ranges_m.empty()) return "scan without rays";
  if (!std::isfinite(scan.first_ray_rad) ||
      !(turn_rad > 0.0 && turn_rad < kMostTurns * 2.0 * kPi)) {
    return "scan's angles are no part of a turn";
  }
  if (!(scan.ray_period_s >= 0.0 && scan.ray_period_s < 1.0)) return "scan's time_increment";
  if (!(scan.least_range_m >= 0.0 && scan.most_range_m > scan.least_range_m)) {
    return "scan's range_min and range_max";
  }
  if (config.min_intensity > 0.0 && scan.intensities.size() != scan.ranges_m.size()) {
    return "scan without intensities";
  }
  return {};
}

std::vector<ScanLight> lightsInScan(const LaserScan& scan, const ScanLightConfig& config) {
  const ScanSegments segments(scan, config);
  std::vector<ScanLight> lights;
  for (const RayRun& run : segments.lights()) {
    const double middle = segments.middleOf(run);
    const double azimuth_rad = scan.first_ray_rad + middle * scan.ray_spacing_rad;
    lights.push_back({run.range_m() * Eigen::Vector2d(std::cos(azimuth_rad), std::sin(azimuth_rad)),
                      scan.stamp + durationFromSeconds(middle * scan.ray_period_s),
                      static_cast<int>(run.rays())});
  }
  std::stable_sort(lights.begin(), lights.end(), [](const ScanLight& left, const ScanLight& right) {
    return left.rays > right.rays;
  });
  return lights;
}

FieldOfView viewOf(const LaserScan& scan) {
  const double spacing_rad = std::abs(scan.ray_spacing_rad);
  const double width_rad = static_cast<double>(scan.ranges_m.size() - 1) * spacing_rad;
  constexpr double kMostSpacings = 2.5;  // two, and rounding
  if (width_rad + kMostSpacings * spacing_rad > 2.0 * kPi) return {};
  const double sense = std::copysign(1.0, scan.ray_spacing_rad);
  return {wrapAngle(scan.first_ray_rad + sense * 0.5 * width_rad), width_rad};
}

double edgeVariance(const LaserScan& scan) {
  // Each edge is uniform in a spacing s, s^2 / 12; the middle has half of both errors.
  constexpr double kPerSpacing2 = 1.0 / 24.0;
  return kPerSpacing2 * scan.ray_spacing_rad * scan.ray_spacing_rad;
}

BearingSet atOneMoment(const std::vector<TimedBearing>& candidates,
                       const std::optional<BearingPrediction>& prediction) {
  // Of a robot that is being calibrated; over a scan of 0.2 s no more than a bearing may be wrong
  // by.
  constexpr double kTurn_radps = 1.5;
  constexpr Duration kRecent = std::chrono::milliseconds(500);
  BearingSet set;
  if (candidates.empty()) return set;
  const TimedBearing* best = &candidates.front();
  if (prediction && std::chrono::abs(best->stamp - prediction->stamp) < kRecent) {
    const auto off = [&](const TimedBearing& candidate) {
      return std::abs(wrapAngle(candidate.bearing.azimuth_rad - prediction->azimuth_rad));
    };
    for (const TimedBearing& candidate : candidates) {
      if (off(candidate) < off(*best)) best = &candidate;
    }
  }
  set.stamp = best->stamp;
  for (const TimedBearing& candidate : candidates) {
    const double apart_s = secondsFromDuration(candidate.stamp - best->stamp);
    set.candidates.push_back(candidate.bearing);
    set.candidates.back().azimuth_variance_rad2 += std::pow(kTurn_radps * apart_s, 2);
  }
  return set;
}

BearingSet bearingsInScan(const LaserScan& scan, const ScanLightConfig& config,
                          const Eigen::Isometry3d& sensor_from_scan, double stddev_rad,
                          const std::optional<BearingPrediction>& prediction) {
  std::vector<TimedBearing> candidates;
  for (const ScanLight& light : lightsInScan(scan, config)) {
    const Eigen::Vector3d in_scan_m(light.position_m.x(), light.position_m.y(), 0.0);
    Bearing bearing = bearingOfPoint(sensor_from_scan * in_scan_m, stddev_rad);
    bearing.azimuth_variance_rad2 += edgeVariance(scan);
    bearing.elevation_rad = bearing.elevation_variance_rad2 = Bearing().elevation_rad;
    candidates.push_back({bearing, light.stamp});
  }
  BearingSet set = atOneMoment(candidates, prediction);
  if (candidates.empty()) set.stamp = scan.stamp;
  set.view = viewOf(scan);
  const Eigen::Vector3d middle =
      sensor_from_scan.linear() *
      Eigen::Vector3d(std::cos(set.view.centre_rad), std::sin(set.view.centre_rad), 0.0);
  set.view.centre_rad = std::atan2(middle.y(), middle.x());
  return set;
}

}  // namespace bearing_calibration::core
