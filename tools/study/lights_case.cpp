#include "tools/study/lights_case.h"

#include <algorithm>
#include <numeric>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "tools/study/draws.h"

namespace bearing_calibration::core {

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

void spreadHeights(SimulatedCase& simulated, double highest_m) {
  const std::size_t others = simulated.lights.size() - 1;
  for (std::size_t i = 0; i <= others; ++i) {
    const double share = others > 0 ? static_cast<double>(i) / static_cast<double>(others) : 0.0;
    simulated.lights[i].height_m = highest_m * (1.0 - 2.0 * share);
  }
}

std::vector<LightsImage> imagesOf(const ObservationRun& run, std::size_t count) {
  std::vector<LightsImage> images;
  auto observation = run.observations.begin();
  for (const BearingSet& set : run.record.bearings) {
    if (images.size() == count || observation == run.observations.end()) break;
    if (observation->stamp != set.stamp) continue;
    LightsImage image{set.stamp, observation->motion, observation->nearby, {}};
    for (std::size_t i = 0; i < set.candidates.size(); ++i) {
      const Bearing& candidate = set.candidates[i];
      const auto light =
          candidate.light_id == kUnknownLight ? i : static_cast<std::size_t>(candidate.light_id);
      image.lights.at(light) = {candidate.azimuth_rad, candidate.azimuth_variance_rad2,
                                elevationOf(candidate)};
    }
    images.push_back(image);
    ++observation;
  }
  return images;
}

std::vector<Observation> allObservationsOf(const SimulatedCase& simulated,
                                           const std::vector<LightsImage>& images) {
  std::vector<std::size_t> lights(simulated.lights.size());
  std::iota(lights.begin(), lights.end(), std::size_t{0});
  return observationsOf(images, lights);
}

RecordTrack trueTrack(const SimulatedCase& simulated, const ObservationRun& run,
                      const std::vector<LightsImage>& images) {
  const ErrorVector errors = trueErrors(simulated);
  const Pose2& base_from_sensor = simulated.robot.base_from_sensor;
  RecordTrack track;
  track.path.mount << base_from_sensor.position_m, base_from_sensor.yaw_rad;
  track.path.errors = errors;
  std::size_t image = 0;
  for (const Observation& observation : allObservationsOf(simulated, images)) {
    while (run.observations[image].stamp != observation.stamp) ++image;
    PathPoint point{LightPositions(2, simulated.lights.size())};
    for (std::size_t i = 0; i < simulated.lights.size(); ++i) {
      point.lights_in_base.col(static_cast<Eigen::Index>(i)) =
          run.world_from_base[image].inverse() * simulated.lights[i].position_m;
    }
    if (image > 0) {
      const Pose2 motion = run.world_from_base[image - 1].inverse() * run.world_from_base[image];
      const Pose2 measured = correctMotion(run.observations[image].motion, errors).start_from_end;
      point.motion_error << motion.position_m - measured.position_m,
          wrapAngle(motion.yaw_rad - measured.yaw_rad);
    }
    track.path.points.push_back(point);
    track.is_plausible.push_back(true);
  }
  return track;
}

StateEstimate lightsBound(const SimulatedCase& simulated, const ObservationRun& run,
                          std::size_t count) {
  const std::vector<LightsImage> images = imagesOf(run, count);
  const std::vector<Observation> observations = allObservationsOf(simulated, images);
  std::vector<ObservationWeight> weights;
  for (const Observation& observation : observations) {
    weights.push_back({observation.azimuth_variance_rad2, observation.azimuth_variance_rad2});
  }
  const RecordPath path = trueTrack(simulated, run, images).path;
  return smooth(observations, weights, path, kFreePass, simulated.looked_for).last;
}

}  // namespace bearing_calibration::core
