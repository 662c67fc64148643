#include "tools/study/simulated_case.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_odometer.h"
#include "tools/study/draws.h"
#include "tools/study/unmodelled.h"

namespace bearing_calibration::core {
namespace {

/// The paper's robot (section V-A): wheel separation 0.25 m, K = 1e-6 m, encoders at 100 Hz,
/// bearings at 10 Hz with 1 degree.
RobotConfig paperRobot(std::uint64_t seed) {
  constexpr double kSeparation_m = 0.25;
  constexpr double kWheelRadius_m = 0.05;
  constexpr double kTicksPerRevolution = 100000.0;  // so fine that quantisation adds nothing
  constexpr double kMaxWheelSpeed_mps = 2.0;
  constexpr double kChongKleeman_m = 1e-6;
  RobotConfig robot;
  robot.encoders.drive = {
      kSeparation_m, kWheelRadius_m, kWheelRadius_m, kTicksPerRevolution, 32, kMaxWheelSpeed_mps};
  robot.encoders.noise = {kChongKleeman_m, 0.0};
  robot.sensor.stddev_rad = radiansFromDegrees(1.0);
  robot.seed = seed;
  return robot;
}

}  // namespace

SimulatedCase paperCase(std::uint64_t seed) {
  constexpr double kRho_m = 0.1;
  const double phi = radiansFromDegrees(30.0);
  const double psi = radiansFromDegrees(30.0);
  SimulatedCase simulated;
  simulated.robot = paperRobot(seed);
  simulated.robot.base_from_sensor = {polar(kRho_m, phi), phi + psi};
  simulated.robot.world_from_start = {{2.0, 0.0}, 0.5 * kPi};
  simulated.lights = {Light()};
  return simulated;
}

SimulatedCase cornerCase(std::uint64_t seed) {
  constexpr double kInside_m = 0.25;
  SimulatedCase simulated = paperCase(seed);
  simulated.robot.world_from_start = Pose2();  // the square is driven to the left
  simulated.lights.front().position_m = {kInside_m, kInside_m};
  return simulated;
}

SimulatedCase shortCase(std::uint64_t seed) {
  constexpr double kSourceDistance_m = 3.6;
  constexpr double kStated_rad = 0.02;
  constexpr double kStep_m = 0.008;
  constexpr double kNoiseOfStep = 0.02;
  constexpr double kChongKleeman_m = kNoiseOfStep * kNoiseOfStep * kStep_m;
  Draws draws(seed, Draws::Purpose::kCase);
  SimulatedCase simulated = paperCase(seed);
  RobotConfig& robot = simulated.robot;
  robot.base_from_sensor = {{0.3, 0.1}, radiansFromDegrees(60.0)};
  robot.world_from_start = {{0.0, 0.0}, draws.angle()};
  robot.sensor.stddev_rad = radiansFromDegrees(2.0);
  simulated.stated_noise.bearing.value = kStated_rad / robot.sensor.stddev_rad;
  simulated.stated_noise.wheel.value = robot.encoders.noise.independent_k_m / kChongKleeman_m;
  robot.encoders.noise.independent_k_m = kChongKleeman_m;
  simulated.lights.front().position_m = polar(kSourceDistance_m, draws.angle());
  simulated.trajectory.dance_turn_rad = radiansFromDegrees(560.0 / 6.0);
  return simulated;
}

SimulatedCase randomCase(std::uint64_t seed, TrajectoryConfig::Kind kind,
                         const RandomCaseRange& range) {
  Draws draws(seed, Draws::Purpose::kCase);
  SimulatedCase simulated;
  simulated.robot = paperRobot(seed);
  const double rho = draws.between(0.0, range.max_mount_distance_m);
  simulated.robot.base_from_sensor = {polar(rho, draws.angle()), draws.angle()};
  simulated.robot.world_from_start = {{0.0, 0.0}, draws.angle()};
  const double distance = std::exp(
      draws.between(std::log(range.min_light_distance_m), std::log(range.max_light_distance_m)));
  simulated.lights = {Light{polar(distance, draws.angle())}};
  simulated.trajectory.kind = kind;
  simulated.trajectory.seed = seed;
  return simulated;
}

SimulatedCase degenerateCase(std::uint64_t seed) {
  using Kind = TrajectoryConfig::Kind;
  enum class Place : std::uint8_t { kAnywhere, kOnTheLine, kInTheCircle };
  struct Motion {
    Kind kind;
    Place light;
  };
  static const std::vector<Motion> kMotions = {
      {Kind::kStanding, Place::kAnywhere},     {Kind::kLine, Place::kAnywhere},
      {Kind::kBackAndForth, Place::kAnywhere}, {Kind::kCircle, Place::kAnywhere},
      {Kind::kSpin, Place::kAnywhere},         {Kind::kLine, Place::kOnTheLine},
      {Kind::kCircle, Place::kInTheCircle}};
  const Motion& motion = kMotions[(seed - 1) % kMotions.size()];
  SimulatedCase simulated = randomCase(seed, motion.kind, RandomCaseRange());
  const Pose2& start = simulated.robot.world_from_start;
  Eigen::Vector2d& light = simulated.lights.front().position_m;
  if (motion.light == Place::kOnTheLine) light = start * Eigen::Vector2d(light.norm(), 0.0);
  if (motion.light == Place::kInTheCircle) {
    light =
        start * Eigen::Vector2d(0.0, simulated.trajectory.circle_radius_m);  // driven to the left
  }
  return simulated;
}

void addSlips(SimulatedCase& simulated, int count, std::uint64_t seed) {
  Draws draws(seed, Draws::Purpose::kSlips);
  for (int i = 0; i < count; ++i) {
    WheelSlip slip;
    slip.when = {draws.between(0.0, simulated.duration_s), draws.between(0.2, 0.5)};
    slip.wheel = draws.coin() ? WheelSlip::Wheel::kLeft : WheelSlip::Wheel::kRight;
    const double off = draws.between(0.3, 0.7);
    slip.excess = draws.coin() ? off : -off;
    simulated.robot.faults.slips.push_back(slip);
  }
}

void makeImperfect(SimulatedCase& simulated, const ImperfectRobot& how, std::uint64_t seed) {
  Draws draws(seed, Draws::Purpose::kErrors);
  RobotConfig& robot = simulated.robot;
  robot.stamp_latency_s = how.time_offset_s + draws.between(0.0, 1.0) * how.max_random_offset_s;
  const double ratio = how.ratio + draws.gaussian(how.random_ratio_stddev);
  robot.separation_factor = 1.0 + draws.gaussian(how.random_separation_stddev);
  const Eigen::Vector2d tilt = polar(how.tilt_rad, draws.angle());
  robot.sensor.roll_rad = tilt.x();
  robot.sensor.pitch_rad = tilt.y();
  const Eigen::Vector2d harmonic = polar(how.harmonic_rad, draws.angle());
  robot.sensor.harmonic_cos_rad = harmonic.x();
  robot.sensor.harmonic_sin_rad = harmonic.y();
  const double scale = how.scale + draws.gaussian(how.random_scale_stddev);
  robot.encoders.left_radius_factor = 1.0 + scale - 0.5 * ratio;
  robot.encoders.right_radius_factor = 1.0 + scale + 0.5 * ratio;
}

void drawNoise(SimulatedCase& simulated, std::uint64_t seed) {
  Draws draws(seed, Draws::Purpose::kNoise);
  const double bearing = std::exp(draws.between(std::log(1.0 / 3.0), std::log(4.0)));
  const double wheel = std::exp(draws.between(std::log(0.1), std::log(100.0)));
  RobotConfig& robot = simulated.robot;
  robot.sensor.stddev_rad *= bearing;
  robot.encoders.noise.independent_k_m *= wheel;
  robot.encoders.noise.common_k_m *= wheel;
  robot.sensor.correlation = draws.between(0.0, 0.8);
  simulated.stated_noise.bearing.value /= bearing;
  simulated.stated_noise.wheel.value /= wheel;
}

void addOcclusions(SimulatedCase& simulated, double share, std::uint64_t seed) {
  constexpr int kStretches = 5;
  Draws draws(seed, Draws::Purpose::kOcclusions);
  const double length_s = share * simulated.duration_s / kStretches;
  const double every_s = simulated.duration_s / kStretches;
  for (int i = 0; share > 0.0 && i < kStretches; ++i) {
    const double begin_s = draws.between(i * every_s, (i + 1) * every_s - length_s);
    simulated.robot.faults.occlusions.push_back({begin_s, length_s});
  }
}

ErrorPriors usualErrors() {
  constexpr double kTimeOffset_s = 0.1;
  constexpr double kWheelScale = 0.03;
  constexpr double kWheelSeparation = 0.02;
  ErrorPriors priors;
  priors.setBlock(TimeOffset::kName, kTimeOffset_s);
  priors.setBlock(WheelScales::kName, kWheelScale);
  priors.setBlock(WheelSeparation::kName, kWheelSeparation);
  return priors;
}

NoisePriors usualNoise() {
  constexpr double kBearing = 1.0;
  constexpr double kWheel = 2.0;
  return {kBearing, kWheel};
}

ErrorVector trueErrors(const SimulatedCase& simulated) {
  const RobotConfig& robot = simulated.robot;
  ErrorVector errors = ErrorVector::Zero();
  errors(placeOf<TimeOffset>()) = robot.stamp_latency_s;
  errors.segment<WheelScales::kSize>(placeOf<WheelScales>())
      << robot.encoders.left_radius_factor - 1.0,
      robot.encoders.right_radius_factor - 1.0;
  errors(placeOf<WheelSeparation>()) = robot.separation_factor - 1.0;
  errors.segment<2>(placeOf<MirrorHarmonic>()) << robot.sensor.harmonic_cos_rad,
      robot.sensor.harmonic_sin_rad;
  errors.segment<2>(placeOf<SensorTilt>()) << robot.sensor.roll_rad, robot.sensor.pitch_rad;
  int light = 0;
  for (const Light& each : simulated.lights) errors(heightAt(light++)) = each.height_m;
  return errors;
}

namespace {

/// A record's images with the motion since the last and the travel around each; the azimuths of
/// those without a light are no numbers.
std::vector<Observation> observationsFromRecord(const SimulatedRecord& record,
                                                const DriveGeometry& drive, const WheelNoise& noise,
                                                bool hidden_too) {
  constexpr double kHidden = std::numeric_limits<double>::quiet_NaN();
  WheelOdometer odometer(drive);
  OdometryTrack track(drive.wheel_separation_m, noise, durationFromSeconds(1.0));
  std::vector<Observation> observations;
  auto ticks = record.ticks.begin();
  for (const BearingSet& set : record.bearings) {
    while (ticks != record.ticks.end() && (track.empty() || track.newest() < set.stamp)) {
      odometer.add(*ticks++);
      track.add(*odometer.travel());
    }
    const bool hidden = set.candidates.empty();
    if ((hidden && !hidden_too) || !track.covers(set.stamp)) continue;
    Observation observation{set.stamp, track.motionTo(set.stamp), kHidden, kHidden,
                            track.travelAround(set.stamp)};
    if (!hidden) {
      const Bearing& bearing = set.candidates.front();
      observation.azimuth_rad = bearing.azimuth_rad;
      observation.azimuth_variance_rad2 = bearing.azimuth_variance_rad2;
      observation.elevation = elevationOf(bearing);
    }
    observations.push_back(observation);
    track.anchorAt(set.stamp);
  }
  return observations;
}

void hideInTurn(double each_s, std::size_t lights, SimulatedRecord* record) {
  const Stamp start = record->ticks.front().stamp;
  for (BearingSet& image : record->bearings) {
    const double turns = secondsFromDuration(image.stamp - start) / each_s;
    const auto hidden = static_cast<std::int32_t>(std::fmod(turns, lights));
    std::vector<Bearing>& seen = image.candidates;
    seen.erase(std::remove_if(seen.begin(), seen.end(),
                              [hidden](const Bearing& light) { return light.light_id == hidden; }),
               seen.end());
  }
}

}  // namespace

std::vector<Observation> observationsFromRecord(const SimulatedRecord& record,
                                                const DriveGeometry& drive,
                                                const WheelNoise& noise) {
  constexpr bool kHiddenToo = false;
  return observationsFromRecord(record, drive, noise, kHiddenToo);
}

ObservationRun simulate(const SimulatedCase& simulated) {
  const RobotConfig& robot = simulated.robot;
  const double separation = robot.encoders.drive.wheel_separation_m * robot.separation_factor;
  return simulateAlong(simulated, makeTrajectory(simulated.trajectory, separation));
}

ObservationRun simulateAlong(const SimulatedCase& simulated, Trajectory trajectory) {
  RobotConfig robot = simulated.robot;
  if (simulated.unmodelled == Unmodelled::kHeavyTails) robot.sensor.stddev_rad = 0.0;
  RobotSimulator simulator(robot, simulated.lights, std::move(trajectory));
  SimulatedRecord seen = record(&simulator, simulated.duration_s);
  distort(simulated, &seen);
  if (simulated.change_record) simulated.change_record(&seen);
  if (simulated.hide_in_turn_s > 0.0) {
    hideInTurn(simulated.hide_in_turn_s, simulated.lights.size(), &seen);
  }
  return runFromRecord(simulated, std::move(seen));
}

ObservationRun runFromRecord(const SimulatedCase& simulated, SimulatedRecord record) {
  const RobotConfig& robot = simulated.robot;
  ObservationRun run;
  run.record = std::move(record);
  run.observations = observationsFromRecord(run.record, robot.encoders.drive, robot.encoders.noise);
  const ErrorVector errors = trueErrors(simulated);
  constexpr bool kHiddenToo = true;
  std::size_t at = 0;
  for (const Observation& look :
       observationsFromRecord(run.record, robot.encoders.drive, robot.encoders.noise, kHiddenToo)) {
    while (run.record.bearings[at].stamp != look.stamp) ++at;
    // the record's poses are those of the moments when the images were taken
    const Pose2 world_from_base =
        run.record.world_from_base[at] * stampFromMoment(look, errors).inverse();
    const Eigen::Vector2d light = world_from_base.inverse() * simulated.lights.front().position_m;
    run.at_images.emplace_back();
    run.at_images.back().stamp = look.stamp;
    run.at_images.back().world_from_base = world_from_base;
    run.at_images.back().cartesian << light, robot.base_from_sensor.position_m,
        robot.base_from_sensor.yaw_rad;
    if (std::isnan(look.azimuth_rad)) continue;
    run.truth.push_back(run.at_images.back().cartesian);
    run.world_from_base.push_back(world_from_base);
  }
  return run;
}

}  // namespace bearing_calibration::core
