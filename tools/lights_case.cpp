#include "tools/lights_case.h"

#include <algorithm>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_odometer.h"
#include "tools/draws.h"

namespace bearing_calibration {
namespace {

LightsLayout layoutOf(const SimulatedCase& simulated) {
  return {errorsInUse(simulated.looked_for), static_cast<int>(simulated.lights.size())};
}

/// What the odometry missed on the way to each image.
std::vector<Eigen::Vector3d> trueMotionErrors(const SimulatedCase& simulated, const SightRun& run,
                                              const std::vector<LightsImage>& images) {
  const ErrorVector errors = trueErrors(simulated);
  std::vector<Eigen::Vector3d> motion_errors(images.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 1; i < images.size(); ++i) {
    const Pose2 motion = run.world_from_base[i - 1].inverse() * run.world_from_base[i];
    const Pose2 measured = correctMotion<kErrorCount>(images[i].motion, errors).start_from_end;
    motion_errors[i] << motion.position_m - measured.position_m,
        wrapAngle(motion.yaw_rad - measured.yaw_rad);
  }
  return motion_errors;
}

}  // namespace

void addLights(SimulatedCase& simulated, int count, std::uint64_t seed) {
  constexpr double kNearest = 0.75;  // of the first one's distance
  constexpr double kFarthest = 1.25;
  constexpr double kGivingIn = 0.95;    // where the way is all around
  constexpr double kClearance_m = 0.5;  // a robot does not drive through a lamp
  Draws draws(seed, Draws::Purpose::kLights);
  const Eigen::Vector2d start = simulated.robot.world_from_start.position_m;
  const double distance_m = (simulated.lights.front().position_m - start).norm();
  double clearance_m = std::min(kClearance_m, 0.5 * distance_m);
  const std::vector<Pose2> path = simulate(simulated).world_from_base;
  while (static_cast<int>(simulated.lights.size()) < count) {
    const double far_m = distance_m * draws.between(kNearest, kFarthest);
    const Eigen::Vector2d place = start + polar(far_m, draws.angle());
    const bool is_free = std::none_of(path.begin(), path.end(), [&](const Pose2& base) {
      return (base.position_m - place).norm() < clearance_m;
    });
    if (is_free) {
      simulated.lights.push_back(Light{place});
    } else {
      clearance_m *= kGivingIn;
    }
  }
}

std::vector<LightsImage> imagesOf(const SightRun& run, std::size_t count) {
  std::vector<LightsImage> images;
  auto sight = run.sights.begin();
  for (const BearingSet& set : run.record.bearings) {
    if (images.size() == count || sight == run.sights.end()) break;
    if (sight->stamp != set.stamp) continue;
    LightsImage image{set.stamp, sight->motion, sight->nearby, {}};
    for (std::size_t i = 0; i < set.candidates.size(); ++i) {
      const Bearing& candidate = set.candidates[i];
      const auto light =
          candidate.light_id == kUnknownLight ? i : static_cast<std::size_t>(candidate.light_id);
      image.lights.at(light) = {candidate.azimuth_rad, candidate.azimuth_variance_rad2};
    }
    images.push_back(image);
    ++sight;
  }
  return images;
}

LightsStart startAtTruth(const SimulatedCase& simulated, const SightRun& run,
                         const std::vector<LightsImage>& images) {
  LightsStart start;
  start.layout = layoutOf(simulated);
  const Pose2 base_from_world = run.world_from_base[images.size() - 1].inverse();
  LightsVector last(start.layout.size());
  last.head<kMountSize>() << simulated.robot.base_from_sensor.position_m,
      simulated.robot.base_from_sensor.yaw_rad;
  last.segment(kMountSize, start.layout.errors) = trueErrors(simulated).head(start.layout.errors);
  for (int i = 0; i < start.layout.lights; ++i) {
    last.segment<2>(start.layout.lightAt(i)) =
        base_from_world * simulated.lights[static_cast<std::size_t>(i)].position_m;
  }
  start.path = pathTo(start.layout, last, images, trueMotionErrors(simulated, run, images));
  start.weights.widening.fill(1.0);
  for (const LightsImage& image : images) {
    LightsImageWeight weight;
    for (std::size_t i = 0; i < image.lights.size(); ++i) weight.use[i] = image.lights[i].isSeen();
    start.weights.images.push_back(weight);
  }
  return start;
}

RobotEstimate lightsBound(const SimulatedCase& simulated, const SightRun& run, std::size_t count) {
  const std::vector<LightsImage> images = imagesOf(run, count);
  const LightsStart start = startAtTruth(simulated, run, images);
  return smoothLights(images, start.weights, start.layout, start.path, simulated.looked_for)
      .last.robot(0);
}

}  // namespace bearing_calibration
