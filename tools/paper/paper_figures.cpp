#include "tools/paper/paper_figures.h"

#include <cmath>
#include <opencv2/core/mat.hpp>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/default_rig.h"
#include "support/rendered_observations.h"

namespace bearing_calibration::core {
namespace {

/// "Known" for the paper's filter, which says nothing of D and theta.
constexpr double kKnownDistance_m = 1e-3;
constexpr double kKnownAngle_rad = 2e-3;
constexpr double kPaperStddev_deg = 1.0;

PaperStart paperStart(const Eigen::Vector3d& guess, const Eigen::Vector3d& stddev) {
  PaperStart start;
  start.mount_guess = guess;
  start.stddev << kKnownDistance_m, kKnownAngle_rad, stddev;
  return start;
}

PaperFigure simulatedFigure(const std::string& name) {
  constexpr double kAngleStddev_deg = 45.0;  // the start is off by 30
  constexpr double kRhoStddev_m = 0.2;
  const double angle = radiansFromDegrees(kAngleStddev_deg);
  return {name, paperCase(1), paperStart(Eigen::Vector3d::Zero(), {angle, kRhoStddev_m, angle}),
          radiansFromDegrees(kPaperStddev_deg)};
}

/// @param variance_m  of a wheel's step over its mean
PaperFigure randomFigure(const std::string& name, double variance_m) {
  constexpr double kDuration_s = 1000.0;
  constexpr double kAnyWheelSpeed_mps = 20.0;  // the literal steps reach 3 m/s
  PaperFigure figure = simulatedFigure(name);
  figure.simulated.duration_s = kDuration_s;
  figure.simulated.trajectory.kind = TrajectoryConfig::Kind::kRandom;
  figure.simulated.trajectory.random_variance_m = variance_m;
  figure.simulated.robot.encoders.drive.max_wheel_speed_mps = kAnyWheelSpeed_mps;
  return figure;
}

}  // namespace

std::vector<PaperFigure> simulatedFigures() {
  // A step of 2 mm: its variance is 0.01 m times the step; or its standard deviation is 0.01 m, or
  // a tenth of the step, or a hundredth.
  constexpr double kStep_m = 0.2 * 0.01;
  constexpr double kLiteral_m = 0.01;
  constexpr double kCentimetre_m = 0.01 * 0.01 / kStep_m;
  constexpr double kTenth_m = 0.1 * 0.1 * kStep_m;
  constexpr double kHundredth_m = 0.01 * 0.01 * kStep_m;
  constexpr double kExactStddev_rad = 1e-6;
  PaperFigure exact = simulatedFigure("fig3_exact_camera");
  exact.simulated.robot.sensor.stddev_rad = kExactStddev_rad;
  return {randomFigure("fig2_literal", kLiteral_m),
          randomFigure("fig2_centimetre", kCentimetre_m),
          randomFigure("fig2_tenth", kTenth_m),
          randomFigure("fig2_hundredth", kHundredth_m),
          simulatedFigure("fig3"),
          exact};
}

PaperFigure experimentFigure() {
  constexpr double kPhi_rad = -3.11;  // the paper's final estimates are the truth here
  constexpr double kRho_m = 0.074;
  constexpr double kPsi_rad = -1.58;
  constexpr double kHandStddev_rad = 0.1;  // of an angle measured by hand
  constexpr double kRhoStddev_m = 0.1;
  constexpr double kLightRadius_m = 0.02;  // a ring of LEDs
  PaperFigure figure{
      "fig5", paperCase(1),
      paperStart({-kPi, 0.0, -0.5 * kPi}, {kHandStddev_rad, kRhoStddev_m, kHandStddev_rad}),
      radiansFromDegrees(kPaperStddev_deg)};
  RobotConfig& robot = figure.simulated.robot;
  robot.base_from_sensor = {kRho_m * Eigen::Vector2d(std::cos(kPhi_rad), std::sin(kPhi_rad)),
                            wrapAngle(kPhi_rad + kPsi_rad)};
  robot.world_from_start = {{1.5, 0.0}, 0.5 * kPi};
  Light& light = figure.simulated.lights.front();
  light.height_m = test::kDefaultLightHeight_m;
  light.radius_m = kLightRadius_m;
  return figure;
}

ObservationRun simulatedRun(const PaperFigure& figure, std::uint64_t seed) {
  SimulatedCase simulated = figure.simulated;
  simulated.robot.seed = seed;
  simulated.trajectory.seed = seed;
  return simulate(simulated);
}

CameraRun renderedRun(const PaperFigure& figure, const std::function<void(int)>& on_image) {
  RendererConfig rig = test::renderedRig();
  rig.rays_per_light = RendererConfig().rays_per_light;
  ImageRenderer renderer(rig, roomRadiance({}));
  DetectorConfig config = test::detectorOf(rig);
  config.light.radius_m = figure.simulated.lights.front().radius_m;
  config.light.min_radius_m = config.light.radius_m;  // the ring's size is known
  config.light.half_height_m = config.light.radius_m;
  LightDetector detector(config);

  CameraRun camera;
  test::BearingErrors errors;
  SimulatedRecord record = simulatedRun(figure, 1).record;
  for (std::size_t i = 0; i < record.bearings.size(); ++i) {
    const Pose2 world_from_sensor =
        record.world_from_base[i] * figure.simulated.robot.base_from_sensor;
    const DetectionResult& seen =
        detector.detect(renderer.render(figure.simulated.lights, {world_from_sensor}, i));
    record.bearings[i].candidates.clear();
    if (seen.lights.size() == 1) {
      record.bearings[i].candidates.push_back(seen.lights.front().bearing);
      errors.add(seen.lights.front().bearing,
                 azimuthOf(figure.simulated.lights.front(), world_from_sensor));
    }
    on_image(++camera.images);
  }
  camera.found = errors.found;
  camera.rms_error_rad = radiansFromDegrees(errors.rmse_deg());
  camera.bias_rad = radiansFromDegrees(errors.bias_deg());
  camera.run = runFromRecord(figure.simulated, std::move(record));
  for (Observation& observation : camera.run.observations) {
    observation.azimuth_variance_rad2 = camera.rms_error_rad * camera.rms_error_rad;
  }
  return camera;
}

}  // namespace bearing_calibration::core
