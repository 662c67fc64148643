#include "bearing_calibration/simulation/scene.h"

#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration {

std::vector<std::string> SceneConfig::validate() const {
  Requirements require;
  for (const Light& light : lights) {
    require.positive("world/lights: the brightness", light.brightness);
    require.notNegative("world/lights: the radius", light.radius_m);
  }
  require.add(ring.validate());
  require.add(room.validate());
  require.add(clutter.validate());
  return require.errors();
}

Scene drawScene(const SceneConfig& config, std::uint64_t seed) {
  validated(config);
  SceneRandom random(seed);
  Scene scene;
  scene.surroundings = withClutter(roomRadiance(config.room), drawClutter(config.clutter, &random));
  scene.holders = drawHolders(config.clutter, &random);
  for (const Light& light : config.lights) {
    for (const Light& led : drawLeds(light, config.ring, &random)) scene.lights.push_back(led);
  }
  return scene;
}

}  // namespace bearing_calibration
