#include "bearing_calibration/simulation/scene.h"

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration::core {

std::vector<std::string> SceneConfig::validate() const {
  Requirements require;
  constexpr double kDarkest = 1e-6;
  constexpr double kBrightest = 1e6;
  constexpr double kLargest_m = 10.0;
  for (const Light& light : lights) {
    const Eigen::Vector3d place_m(light.position_m.x(), light.position_m.y(), light.height_m);
    require.between("world/lights: the distance", place_m.cwiseAbs().maxCoeff(), 0.0,
                    plausible::kFarthest_m);
    require.between("world/lights: the brightness", light.brightness, kDarkest, kBrightest);
    require.between("world/lights: the radius", light.radius_m, 0.0, kLargest_m);
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

}  // namespace bearing_calibration::core
