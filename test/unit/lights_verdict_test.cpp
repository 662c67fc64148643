// What a calibration with several lights says of them, image by image.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/mount_calibration.h"
#include "bearing_calibration/calibration/several_lights.h"
#include "bearing_calibration/common/angle.h"
#include "tools/study/default_calibration.h"
#include "tools/study/lights_case.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

/// A drive past lights that have numbers.
SimulatedCase danceWith(int lights, std::uint64_t seed, double duration_s) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = duration_s;
  addLights(simulated, lights, seed);
  simulated.robot.sensor.identifies_lights = true;
  return simulated;
}

std::vector<Frame> framesOf(const SimulatedCase& simulated) {
  const ObservationRun run = simulate(simulated);
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < run.observations.size(); ++i) {
    const Observation& observation = run.observations[i];
    frames.push_back({run.record.bearings[i], observation.motion, observation.nearby});
    EXPECT_EQ(frames.back().image.stamp, observation.stamp);
  }
  return frames;
}

CalibratorConfig configOf(const SimulatedCase& simulated) {
  const EncoderConfig& encoders = simulated.robot.encoders;
  CalibratorConfig config = defaultCalibration(encoders.drive, encoders.noise);
  config.max_lights = static_cast<int>(simulated.lights.size());
  return config;
}

CalibrationResult resultOf(const SeveralLights& lights) {
  CalibrationResult result;
  lights.describe(&result);
  return result;
}

// All bearings of the one are turned, as those of a reflection can be.
TEST(LightsVerdict, LightsWithoutNumbersAreCountedFromOne) {
  const SimulatedCase simulated = danceWith(2, 4, 60.0);
  SeveralLights lights(configOf(simulated));
  for (Frame frame : framesOf(simulated)) {
    for (Bearing& candidate : frame.image.candidates) {
      if (candidate.light_id == 1) candidate.azimuth_rad += radiansFromDegrees(6.0);
      candidate.light_id = kUnknownLight;
    }
    lights.process(frame);
  }
  const CalibrationResult result = resultOf(lights);
  ASSERT_EQ(result.cause, Fault::kLightsDisagree) << result.advice;
  const auto says = [&](const std::string& name) {
    return result.advice.find("(" + name + " against others)") != std::string::npos;
  };
  EXPECT_TRUE(says("light number 1") || says("light number 2")) << result.advice;
}

// What the others show is theirs: one that is hidden neither takes it nor is lost by it.
TEST(LightsVerdict, OneWithoutANumberIsKeptWhileItIsHidden) {
  constexpr double kHidden_s = 60.0;
  constexpr double kShown_s = 90.0;
  const SimulatedCase simulated = danceWith(3, 4, 100.0);
  const std::vector<Frame> frames = framesOf(simulated);
  for (const std::int32_t hidden : {0, 2}) {
    SeveralLights lights(configOf(simulated));
    std::uint32_t used_before = 0;
    for (Frame frame : frames) {
      const double time_s = secondsFromDuration(frame.image.stamp - frames.front().image.stamp);
      auto& candidates = frame.image.candidates;
      if (time_s > kHidden_s && time_s < kShown_s) {
        candidates.erase(
            std::remove_if(candidates.begin(), candidates.end(),
                           [&](const Bearing& candidate) { return candidate.light_id == hidden; }),
            candidates.end());
      }
      for (Bearing& candidate : candidates) candidate.light_id = kUnknownLight;
      lights.process(frame);
      if (time_s < kHidden_s) used_before = resultOf(lights).bearings_used;
    }
    EXPECT_EQ(lights.newStarts(), 0) << hidden;
    const CalibrationResult result = resultOf(lights);
    EXPECT_GT(result.bearings_used, used_before + 2 * 400);
    for (const LightSummary& light : result.lights) EXPECT_TRUE(light.in_estimate) << hidden;
  }
}

// Two of three lights go out of view, and then the mount is displaced. In the end they are no
// witnesses: the one that is left is doubted first, and believed once it has said so for long.
TEST(LightsVerdict, TheMountHasMovedWhenAllInViewSaySoForLong) {
  constexpr double kDisplaced_s = 40.0;
  SimulatedCase simulated = danceWith(3, 8, 120.0);
  simulated.robot.steps_per_bearing = 20;  // as many images as are enough
  simulated.robot.sensor.stddev_rad = radiansFromDegrees(0.5);
  const std::vector<Frame> before = framesOf(simulated);
  simulated.robot.base_from_sensor.position_m.x() += 0.03;
  simulated.robot.base_from_sensor.yaw_rad += radiansFromDegrees(8.0);
  const std::vector<Frame> after = framesOf(simulated);

  CalibratorConfig config = configOf(simulated);
  config.refit_growth = 0.05;
  SeveralLights lights(config);
  bool was_doubted = false;
  const Stamp displaced = before.front().image.stamp + durationFromSeconds(kDisplaced_s);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool is_displaced = before[i].image.stamp >= displaced;
    Frame frame = is_displaced ? after[i] : before[i];
    if (is_displaced) frame.image.candidates.resize(1);
    lights.process(frame);
    const CalibrationResult result = resultOf(lights);
    if (result.cause == Fault::kMountMoved) break;
    was_doubted = was_doubted || result.advice.find("light 0 reports") != std::string::npos;
  }
  EXPECT_TRUE(was_doubted);
  const CalibrationResult result = resultOf(lights);
  EXPECT_EQ(result.state, CalibrationState::kInconsistent);
  EXPECT_EQ(result.cause, Fault::kMountMoved) << result.advice;
}

// A full record gives its oldest part away, but for what is in the one that all lights share.
TEST(LightsVerdict, ALightKeepsWhatTheOthersHaveNotGivenAway) {
  const SimulatedCase simulated = danceWith(2, 3, 60.0);
  CalibratorConfig config = configOf(simulated);
  config.initializer.record.capacity = 200;
  const auto firstKeptOf = [&](std::optional<Stamp> shared_since) {
    MountCalibration light(config);
    if (shared_since) light.shareSince(*shared_since);
    for (Frame frame : framesOf(simulated)) {
      frame.image.candidates.resize(1);
      light.process(frame);
    }
    EXPECT_TRUE(light.isFound());
    return light.solution()->stamps.front();
  };
  const Stamp first = framesOf(simulated).front().image.stamp;
  EXPECT_EQ(firstKeptOf(std::nullopt), first);
  const Stamp end = first + durationFromSeconds(simulated.duration_s);
  EXPECT_GT(firstKeptOf(end), first);
}

// A turn counts as the way of a point half a metre from the centre.
TEST(MountCalibration, CountsTheWaySinceItsLightWasSeenWithItsTurns) {
  MountCalibration light{CalibratorConfig()};
  for (int i = 1; i <= 4; ++i) {
    Frame frame;
    frame.image.stamp = stampFromSeconds(0.1 * i);
    frame.motion = append(frame.motion, {0.1, 0.3}, 0.25, WheelNoise());  // 0.2 m and 0.8 rad
    light.process(frame);
  }
  EXPECT_NEAR(light.unseenFor_m(), 4 * (0.2 + 0.5 * 0.8), 1e-12);
}

}  // namespace
}  // namespace bearing_calibration::core
