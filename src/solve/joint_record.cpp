#include "bearing_calibration/solve/joint_record.h"

#include <Eigen/LU>
#include <algorithm>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/paper_state.h"
#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {
namespace {

Pose2 corrected(const OdometryIncrement& motion, const ErrorVector& errors) {
  return correctMotion<kErrorCount>(motion, errors).start_from_end;
}

Pose2 withError(const Pose2& measured, const Eigen::Vector3d& error) {
  return {measured.position_m + error.head<2>(), wrapAngle(measured.yaw_rad + error.z())};
}

/// The errors of all motions that bring the base where a light's own fit has it. Between two of its
/// observations the last motion carries all of it.
std::vector<Eigen::Vector3d> motionErrorsOf(const std::vector<Observation>& observations,
                                            const LandmarkSolution& answer) {
  std::vector<Eigen::Vector3d> motion_errors(observations.size(), Eigen::Vector3d::Zero());
  std::size_t own = 0;
  Pose2 since_own;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!beginsImage(observations, i)) {
      motion_errors[i] = motion_errors[i - 1];
      continue;
    }
    const Pose2 measured = corrected(observations[i].motion, answer.fit.path.errors);
    while (own < answer.stamps.size() && answer.stamps[own] < observations[i].stamp) ++own;
    const bool is_own = own < answer.stamps.size() && answer.stamps[own] == observations[i].stamp;
    if (!is_own) {
      since_own = since_own * measured;
      continue;
    }
    if (own > 0 && i > 0) {
      // the fit's motion between its observations, as far as one last motion can make it
      const Pose2 whole = withError(since_own * measured, answer.fit.path.points[own].motion_error);
      const Pose2 wanted = since_own.inverse() * whole;
      motion_errors[i] << wanted.position_m - measured.position_m,
          wrapAngle(wanted.yaw_rad - measured.yaw_rad);
    }
    since_own = {};
  }
  return motion_errors;
}

/// Where a light's own fit has it, seen from the base at the last image.
Eigen::Vector2d lightAtEnd(const std::vector<Observation>& observations,
                           const LandmarkSolution& answer,
                           const std::vector<Eigen::Vector3d>& motion_errors,
                           const ErrorVector& errors) {
  Eigen::Vector2d light = answer.fit.path.points.back().lights_in_base.col(0);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (observations[i].stamp <= answer.stamps.back() || !beginsImage(observations, i)) continue;
    light =
        withError(corrected(observations[i].motion, errors), motion_errors[i]).inverse() * light;
  }
  return light;
}

bool isRejected(const LandmarkSolution& answer, Stamp stamp) {
  const auto& rejected = answer.fit.rejected;
  return std::any_of(rejected.begin(), rejected.end(),
                     [&](std::size_t own) { return answer.stamps[own] == stamp; });
}

/// Images to which the motion is given up, of all that any of the answers gave up.
std::vector<std::size_t> slipsOf(const std::vector<Observation>& observations,
                                 const std::vector<const LandmarkSolution*>& answers) {
  std::vector<std::size_t> slips;
  for (const LandmarkSolution* answer : answers) {
    for (std::size_t slip : answer->fit.slips) {
      const Stamp stamp = answer->stamps[slip];
      const auto image = std::lower_bound(observations.begin() + 1, observations.end(), stamp,
                                          [](const Observation& observation, Stamp slipped) {
                                            return observation.stamp < slipped;
                                          });
      if (image == observations.end()) continue;
      const auto same = [&](std::size_t other) {
        return isNearSlip(observations[other].stamp, image->stamp);
      };
      if (std::any_of(slips.begin(), slips.end(), same)) continue;
      slips.push_back(static_cast<std::size_t>(image - observations.begin()));
    }
  }
  return slips;
}

}  // namespace

std::vector<Observation> observationsOf(const std::vector<LightsImage>& images,
                                        const std::vector<std::size_t>& lights) {
  std::vector<Observation> observations;
  OdometryIncrement motion;
  for (const LightsImage& image : images) {
    motion = append(motion, image.motion);
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const LightObservation& seen = image.lights.at(lights[i]);
      if (!seen.isSeen()) continue;
      Observation observation{image.stamp, motion, seen.azimuth_rad, seen.azimuth_variance_rad2,
                              image.nearby};
      observation.light = static_cast<int>(i);
      observations.push_back(observation);
      motion = {};
    }
  }
  return observations;
}

RecordPath pathTo(const std::vector<Observation>& observations, const RecordPath& end,
                  const std::vector<Eigen::Vector3d>& motion_errors) {
  RecordPath path = end;
  path.points.assign(observations.size(), end.points.back());
  for (std::size_t i = observations.size(); i-- > 0;) {
    path.points[i].motion_error = motion_errors[i];
    if (i == 0) break;
    LightPositions& before = path.points[i - 1].lights_in_base;
    before = path.points[i].lights_in_base;
    if (!beginsImage(observations, i)) continue;
    const Pose2 start_from_end =
        withError(corrected(observations[i].motion, end.errors), motion_errors[i]);
    for (auto light : before.colwise()) light = start_from_end * Eigen::Vector2d(light);
  }
  return path;
}

const LandmarkSolution& surestOf(const std::vector<const LandmarkSolution*>& answers) {
  const auto size = [](const LandmarkSolution* answer) {
    return mountFromCartesian(answer->average.cartesian).covariance.determinant();
  };
  return **std::min_element(
      answers.begin(), answers.end(),
      [&](const LandmarkSolution* a, const LandmarkSolution* b) { return size(a) < size(b); });
}

std::vector<Observation> withNoise(std::vector<Observation> observations,
                                   const std::vector<const LandmarkSolution*>& answers) {
  const NoiseLevels& surest = surestOf(answers).noise;
  for (Observation& observation : observations) {
    const double factor = answers[static_cast<std::size_t>(observation.light)]->noise.bearing.value;
    observation.azimuth_variance_rad2 *= factor * factor;
    observation.motion = withNoise(observation.motion, surest);
  }
  return observations;
}

JointStart startFromAnswers(const std::vector<Observation>& observations,
                            const std::vector<const LandmarkSolution*>& answers) {
  const LandmarkSolution& surest = surestOf(answers);
  const std::vector<Eigen::Vector3d> motion_errors = motionErrorsOf(observations, surest);
  RecordPath end{{PathPoint()}, surest.fit.path.mount, surest.fit.path.errors};
  LightPositions& lights = end.points.back().lights_in_base;
  lights.resize(2, static_cast<Eigen::Index>(answers.size()));
  for (std::size_t i = 0; i < answers.size(); ++i) {
    lights.col(static_cast<Eigen::Index>(i)) =
        lightAtEnd(observations, *answers[i], motion_errors, end.errors);
  }
  JointStart start;
  start.track.path = pathTo(observations, end, motion_errors);
  for (const Observation& observation : observations) {
    const LandmarkSolution& own = *answers[static_cast<std::size_t>(observation.light)];
    start.track.is_plausible.push_back(!isRejected(own, observation.stamp));
  }
  start.slips.given_up = slipsOf(observations, answers);
  return start;
}

}  // namespace bearing_calibration::core
