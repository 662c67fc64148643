#include "support/rendered_observations.h"

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "bearing_calibration/common/angle.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace test {
namespace {

std::vector<double> levels(ImageRenderer* renderer, const ImageSensor& sensor,
                           const Observation& observation) {
  std::vector<double> levels;
  for (float electrons : renderer->expose({observation.light()}, {observation.worldFromSensor()})) {
    levels.push_back(static_cast<double>(electrons) / sensor.electrons_per_level);
  }
  return levels;
}

}  // namespace

RendererConfig renderedRig() {
  RendererConfig config;
  config.reference_distance_m = 1.0;
  config.reference_height_m = kDefaultLightHeight_m;
  config.rays_per_light = 1 << 16;
  return config;
}

DetectorConfig detectorOf(const RendererConfig& rendered) {
  const CameraRig& rig = rendered.rig;
  DetectorConfig config = defaultDetector();
  config.view = {rig.centre_px.x(), rig.centre_px.y(), rig.handedness};
  config.mirror.focus_distance_m = rig.focus_distance_m;
  return config;
}

double plainWall(double, double) { return 0.05; }

Light Observation::light() const {
  Light light;
  light.height_m = kDefaultLightHeight_m;
  light.brightness = brightness * distance_m * distance_m;
  light.radius_m = radius_m;
  return light;
}

Pose2 Observation::worldFromSensor() const {
  return {{-distance_m * std::cos(azimuth_rad), -distance_m * std::sin(azimuth_rad)}, 0.0};
}

std::vector<Observation> randomObservations(int count, double brightness, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> azimuth(-kPi, kPi);
  std::uniform_real_distribution<double> log_distance(std::log(0.5), std::log(5.0));
  std::vector<Observation> observations;
  for (int i = 0; i < count; ++i) {
    observations.push_back({std::exp(log_distance(random)), azimuth(random), brightness});
  }
  return observations;
}

std::vector<Observation> observationsAt(double distance_m, int count, double brightness,
                                        unsigned seed) {
  std::vector<Observation> observations = randomObservations(count, brightness, seed);
  for (Observation& observation : observations) observation.distance_m = distance_m;
  return observations;
}

void BearingErrors::add(const Bearing& bearing, double true_azimuth_rad) {
  const double error = wrapAngle(bearing.azimuth_rad - true_azimuth_rad);
  ++found;
  sum_rad += error;
  sum_square_rad2 += error * error;
  sum_nees += error * error / bearing.azimuth_variance_rad2;
  sum_variance_rad2 += bearing.azimuth_variance_rad2;
}

double BearingErrors::rmse_deg() const {
  return degreesFromRadians(std::sqrt(sum_square_rad2 / found));
}

double BearingErrors::predicted_deg() const {
  return degreesFromRadians(std::sqrt(sum_variance_rad2 / found));
}

double BearingErrors::bias_deg() const { return degreesFromRadians(sum_rad / found); }

double azimuthBound(ImageRenderer* renderer, const ImageSensor& sensor,
                    const Observation& observation) {
  constexpr double kStep = 1e-3;  // a sixth of a pixel, a tenth of a percent
  const std::vector<double> mean = levels(renderer, sensor, observation);
  std::vector<std::vector<double>> derivatives;
  for (double Observation::*parameter :
       {&Observation::azimuth_rad, &Observation::distance_m, &Observation::brightness}) {
    Observation more = observation;
    Observation less = observation;
    more.*parameter += kStep;
    less.*parameter -= kStep;
    std::vector<double> derivative = levels(renderer, sensor, more);
    const std::vector<double> lower = levels(renderer, sensor, less);
    for (std::size_t i = 0; i < derivative.size(); ++i) {
      derivative[i] = (derivative[i] - lower[i]) / (2.0 * kStep);
    }
    derivatives.push_back(derivative);
  }
  const double read = sensor.read_noise_electrons / sensor.electrons_per_level;
  const double rounding = 1.0 / 12.0;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const Eigen::Vector3d row(derivatives[0][i], derivatives[1][i], derivatives[2][i]);
    information +=
        row * row.transpose() / (mean[i] / sensor.electrons_per_level + read * read + rounding);
  }
  return information.inverse()(0, 0);
}

}  // namespace test
}  // namespace bearing_calibration::core
