#include "tools/study/image_look.h"

#include <algorithm>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/default_rig.h"
#include "support/rendered_observations.h"

namespace bearing_calibration::core {
namespace {

struct SimulatedCamera {
  explicit SimulatedCamera(const RendererConfig& config)
      : renderer(config, test::plainWall), detector(test::detectorOf(config)) {}
  ImageRenderer renderer;
  LightDetector detector;
  std::uint64_t images = 0;
};

RendererConfig cameraConfig(std::uint64_t seed) {
  RendererConfig config = test::renderedRig();
  config.rays_per_light = 4096;  // as config/simulation.yaml has it
  config.seed = seed;
  return config;
}

}  // namespace

std::function<BearingSet(const RobotSimulator&)> imageLook(std::uint64_t seed) {
  const auto camera = std::make_shared<SimulatedCamera>(cameraConfig(seed));
  return [camera](const RobotSimulator& robot) {
    std::vector<Light> lights = robot.lights();
    for (Light& light : lights) {
      light.height_m = test::kDefaultLightHeight_m;
      // makes up for the distance, as an exposure control does
      light.brightness = (light.position_m - robot.worldFromSensor().position_m).squaredNorm();
    }
    const cv::Mat image =
        camera->renderer.render(lights, {robot.worldFromSensor()}, camera->images++);
    const DetectionResult& found = camera->detector.detect(image);
    return bearingsFromLights(found.lights, {}, robot.now(), image.rows);
  };
}

}  // namespace bearing_calibration::core
