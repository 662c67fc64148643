#include "bearing_calibration/calibration/joint_record.h"

#include <Eigen/LU>
#include <algorithm>

#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {

const LandmarkSolution& surestOf(const std::vector<const LandmarkSolution*>& answers) {
  const auto size = [](const LandmarkSolution* answer) {
    return answer->average.mount().covariance.determinant();
  };
  return **std::min_element(
      answers.begin(), answers.end(),
      [&](const LandmarkSolution* a, const LandmarkSolution* b) { return size(a) < size(b); });
}

std::vector<Observation> observationsOf(const std::vector<LightsImage>& images,
                                        const std::vector<std::size_t>& lights) {
  std::vector<Observation> observations;
  OdometryIncrement motion;
  for (const LightsImage& image : images) {
    motion = append(motion, image.motion);
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const LightObservation& seen = image.lights.at(lights[i]);
      if (!seen.isSeen()) continue;
      Observation observation{image.stamp,      motion,
                              seen.azimuth_rad, seen.azimuth_variance_rad2,
                              image.nearby,     seen.elevation};
      observation.light = static_cast<int>(i);
      observations.push_back(observation);
      motion = {};
    }
  }
  return observations;
}

OdometryIncrement motionAfter(const std::vector<Observation>& observations,
                              const std::vector<LightsImage>& images) {
  OdometryIncrement motion;
  for (const LightsImage& image : images) {
    if (image.stamp > observations.back().stamp) motion = append(motion, image.motion);
  }
  return motion;
}

std::vector<Observation> withNoise(std::vector<Observation> observations,
                                   const std::vector<const LandmarkSolution*>& answers) {
  const NoiseLevels& surest = surestOf(answers).noise;
  for (Observation& observation : observations) {
    NoiseLevels levels = answers[static_cast<std::size_t>(observation.light)]->noise;
    levels.wheel = surest.wheel;
    observation = withNoise(observation, levels);
  }
  return observations;
}

std::vector<std::size_t> slipsOf(const std::vector<Observation>& observations,
                                 const std::vector<const LandmarkSolution*>& answers) {
  std::vector<std::size_t> slips;
  for (const LandmarkSolution* answer : answers) {
    for (std::size_t slip : answer->fit.slips) {
      const Stamp stamp = answer->stamps[slip];
      if (stamp <= observations.front().stamp) continue;
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

void setOutliersAside(const std::vector<Observation>& observations,
                      const std::vector<const LandmarkSolution*>& answers, RecordTrack* track) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const LandmarkSolution& own = *answers[static_cast<std::size_t>(observations[i].light)];
    const std::vector<std::size_t>& rejected = own.fit.rejected;
    if (std::any_of(rejected.begin(), rejected.end(), [&](std::size_t outlier) {
          return own.stamps[outlier] == observations[i].stamp;
        })) {
      track->is_plausible[i] = false;
    }
  }
}

}  // namespace bearing_calibration::core
