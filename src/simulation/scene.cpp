#include "bearing_calibration/simulation/scene.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

constexpr int kWaves = 24;  // of a texture

/// What one kind of shape looks like; the default rig sees elevations from -15 to +3 degrees.
struct Look {
  Interval elevation_deg;
  Interval half_width_deg;
  Interval half_height_deg;
  bool is_round;
  Interval brightness;  ///< [full wells]
};
constexpr Look kWindow{{0.0, 5.0}, {2.0, 20.0}, {2.0, 6.0}, false, {0.3, 3.0}};
constexpr Look kLamp{{0.3, 3.0}, {0.7, 3.0}, {0.5, 1.5}, true, {0.4, 4.0}};
constexpr Look kReflection{{-12.0, -1.0}, {0.5, 3.0}, {0.8, 4.0}, true, {0.15, 0.9}};
constexpr Look kPaper{{-12.0, -1.0}, {0.5, 6.0}, {0.5, 4.0}, false, {0.15, 0.6}};

Clutter::Shape drawShape(const Look& look, SceneRandom* random) {
  const auto radians = [&](const Interval& degrees) {
    return radiansFromDegrees(drawBetween(degrees, random));
  };
  // Braces are evaluated in order: it decides what a seed draws.
  return {drawBetween({-kPi, kPi}, random),
          radians(look.elevation_deg),
          radians(look.half_width_deg),
          radians(look.half_height_deg),
          look.is_round,
          drawBetween(look.brightness, random)};
}

std::vector<Clutter::Wave> drawTexture(SceneRandom* random) {
  constexpr Interval kAround{1.0, 60.0};  // the finest is 6 degrees long
  constexpr Interval kUp{-80.0, 80.0};    // [rad/rad] and 4.5 degrees high
  std::vector<Clutter::Wave> waves;
  for (int i = 0; i < kWaves; ++i) {
    waves.push_back({std::round(drawBetween(kAround, random)), drawBetween(kUp, random),
                     drawBetween({-kPi, kPi}, random)});
  }
  return waves;
}

bool covers(const Clutter::Shape& shape, double azimuth_rad, double elevation_rad) {
  const double x = wrapAngle(azimuth_rad - shape.azimuth_rad) / shape.half_width_rad;
  const double y = (elevation_rad - shape.elevation_rad) / shape.half_height_rad;
  return shape.is_round ? x * x + y * y <= 1.0 : std::abs(x) <= 1.0 && std::abs(y) <= 1.0;
}

/// The waves' sum, evaluated side by side: a scene asks for it some million times.
class Texture {
 public:
  explicit Texture(const Clutter& clutter)
      : around_(clutter.texture.size()), up_(around_.size()), phase_rad_(around_.size()) {
    for (Eigen::Index i = 0; i < around_.size(); ++i) {
      const Clutter::Wave& wave = clutter.texture[static_cast<std::size_t>(i)];
      around_(i) = static_cast<float>(wave.around);
      up_(i) = static_cast<float>(wave.up);
      phase_rad_(i) = static_cast<float>(wave.phase_rad);
    }
    const double stddev = std::sqrt(0.5 * static_cast<double>(clutter.texture.size()));
    if (clutter.texture_contrast > 0.0) scale_ = clutter.texture_contrast / stddev;
  }

  double at(double azimuth_rad, double elevation_rad) const {
    if (scale_ == 0.0) return 1.0;
    const auto angle_rad = around_ * static_cast<float>(azimuth_rad) +
                           up_ * static_cast<float>(elevation_rad) + phase_rad_;
    return std::max(0.0, 1.0 + scale_ * static_cast<double>(angle_rad.sin().sum()));
  }

 private:
  using Waves = Eigen::Array<float, Eigen::Dynamic, 1, Eigen::ColMajor, kWaves, 1>;
  Waves around_, up_, phase_rad_;
  double scale_ = 0.0;
};

void declareCount(Parameters& params, const std::string& name, CountRange& count) {
  constexpr double kMost = 100.0;  // more cover the whole view
  std::vector<double> range{1.0 * count.least, 1.0 * count.most};
  params.read(name, range);
  const bool is_one = 0.0 <= range[0] && range[0] <= range[1] && range[1] <= kMost &&
                      range[0] == std::floor(range[0]) && range[1] == std::floor(range[1]);
  params.that(is_one,
              name + " must be [least, most], whole numbers with 0 <= least <= most <= 100");
  if (is_one) count = {static_cast<int>(range[0]), static_cast<int>(range[1])};
}

void declareInterval(Parameters& params, const std::string& name, double most, Interval& interval) {
  std::vector<double> range{interval.low, interval.high};
  params.read(name, range);
  params.that(0.0 <= range[0] && range[0] <= range[1] && range[1] <= most,
              name + formatted(" must be [low, high] with 0 <= low <= high <= %g", most));
  interval = {range[0], range[1]};
}

}  // namespace

void ClutterConfig::declare(Parameters& params) {
  constexpr int kMostHolders = 12;
  constexpr double kLargestHalfWidth_rad = 0.2;  // 11 degrees: more of them leave nothing to see
  declareCount(params, "clutter/windows", windows);
  declareCount(params, "clutter/lamps", lamps);
  declareCount(params, "clutter/reflections", reflections);
  declareCount(params, "clutter/papers", papers);
  declareInterval(params, "clutter/texture_contrast", 1.0, texture_contrast);
  params.integer("clutter/holders", holders, 0, kMostHolders);
  declareInterval(params, "clutter/holder_half_width", kLargestHalfWidth_rad,
                  holder_half_width_rad);
}

Clutter drawClutter(const ClutterConfig& config, SceneRandom* random) {
  Clutter clutter;
  const auto add = [&](const CountRange& count, const Look& look) {
    for (int left = drawCount(count, random); left > 0; --left) {
      clutter.shapes.push_back(drawShape(look, random));
    }
  };
  add(config.windows, kWindow);
  add(config.lamps, kLamp);
  add(config.reflections, kReflection);
  add(config.papers, kPaper);
  clutter.texture_contrast = drawBetween(config.texture_contrast, random);
  clutter.texture = drawTexture(random);
  return clutter;
}

std::vector<MirrorHolder> drawHolders(const ClutterConfig& config, SceneRandom* random) {
  const double first_rad = drawBetween({-kPi, kPi}, random);
  const double half_width_rad = drawBetween(config.holder_half_width_rad, random);
  std::vector<MirrorHolder> holders;
  for (int i = 0; i < config.holders; ++i) {
    holders.push_back({wrapAngle(first_rad + 2.0 * kPi * i / config.holders), half_width_rad});
  }
  return holders;
}

bool isBehind(const std::vector<MirrorHolder>& holders, double azimuth_rad, double margin_rad) {
  return std::any_of(holders.begin(), holders.end(), [&](const MirrorHolder& holder) {
    return std::abs(wrapAngle(azimuth_rad - holder.azimuth_rad)) <
           holder.half_width_rad + margin_rad;
  });
}

RadianceFunction withClutter(const RadianceFunction& walls, const Clutter& clutter) {
  return [walls, clutter, texture = Texture(clutter)](double azimuth_rad, double elevation_rad) {
    double brightness = walls(azimuth_rad, elevation_rad) * texture.at(azimuth_rad, elevation_rad);
    for (const Clutter::Shape& shape : clutter.shapes) {
      if (covers(shape, azimuth_rad, elevation_rad)) {
        brightness = std::max(brightness, shape.brightness);
      }
    }
    return brightness;
  };
}

void LedRing::declare(Parameters& params) {
  constexpr int kMostLeds = 64;  // each of them costs as much as a light
  constexpr double kLargest_m = 10.0;
  params.integer("ring/leds", leds, 0, kMostLeds);
  params.number("ring/radius", radius_m, 0.0, kLargest_m);
  params.number("ring/brightness_spread", brightness_spread, 0.0, 1.0);
}

std::vector<Light> drawLeds(const Light& light, const LedRing& ring, SceneRandom* random) {
  if (ring.leds == 0) return {light};
  std::normal_distribution<double> normal(1.0, ring.brightness_spread);
  std::vector<Light> leds;
  for (int i = 0; i < ring.leds; ++i) {
    const double angle_rad = 2.0 * kPi * i / ring.leds;
    Light led = light;
    led.position_m += ring.radius_m * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    led.brightness *= std::max(0.0, normal(*random)) / ring.leds;
    led.radius_m = 0.0;
    leds.push_back(led);
  }
  return leds;
}

void SceneConfig::declare(Parameters& params) {
  constexpr double kDarkest = 1e-6;
  constexpr double kBrightest = 1e6;
  constexpr double kLargest_m = 10.0;
  params.list("world/lights", 5, lights, [](const auto& row) {
    return Light{{row[0], row[1]}, row[2], row[3], row[4]};
  });
  for (const Light& light : lights) {
    const Eigen::Vector3d place_m(light.position_m.x(), light.position_m.y(), light.height_m);
    params.between("world/lights: the distance", place_m.cwiseAbs().maxCoeff(), 0.0,
                   plausible::kFarthest_m);
    params.between("world/lights: the brightness", light.brightness, kDarkest, kBrightest);
    params.between("world/lights: the radius", light.radius_m, 0.0, kLargest_m);
  }
  ring.declare(params);
  room.declare(params);
  clutter.declare(params);
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
