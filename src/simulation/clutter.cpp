#include "bearing_calibration/simulation/clutter.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration::core {
namespace {

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
  constexpr int kWaves = 24;
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

double textureAt(const Clutter& clutter, double azimuth_rad, double elevation_rad) {
  if (clutter.texture_contrast <= 0.0) return 1.0;
  double sum = 0.0;
  for (const Clutter::Wave& wave : clutter.texture) {
    sum += std::sin(wave.around * azimuth_rad + wave.up * elevation_rad + wave.phase_rad);
  }
  const double stddev = std::sqrt(0.5 * static_cast<double>(clutter.texture.size()));
  return std::max(0.0, 1.0 + clutter.texture_contrast * sum / stddev);
}

void requireCount(Requirements* require, const std::string& name, const CountRange& count) {
  constexpr int kMost = 100;  // more cover the whole view
  require->that(0 <= count.least && count.least <= count.most && count.most <= kMost,
                name + " must be [least, most] with 0 <= least <= most <= 100");
}

}  // namespace

std::vector<std::string> ClutterConfig::validate() const {
  constexpr int kMostHolders = 12;
  constexpr double kLargestHalfWidth_rad = 0.2;  // 11 degrees: more of them leave nothing to see
  Requirements require;
  requireCount(&require, "clutter/windows", windows);
  requireCount(&require, "clutter/lamps", lamps);
  requireCount(&require, "clutter/reflections", reflections);
  requireCount(&require, "clutter/papers", papers);
  const Interval& contrast = texture_contrast;
  require.that(0.0 <= contrast.low && contrast.low <= contrast.high && contrast.high <= 1.0,
               "clutter/texture_contrast must be [low, high] with 0 <= low <= high <= 1");
  require.between("clutter/holders", holders, 0, kMostHolders);
  const Interval& half_width = holder_half_width_rad;
  require.that(0.0 <= half_width.low && half_width.low <= half_width.high &&
                   half_width.high <= kLargestHalfWidth_rad,
               "clutter/holder_half_width must be [low, high] with 0 <= low <= high <= 0.2");
  return require.errors();
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
  return [walls, clutter](double azimuth_rad, double elevation_rad) {
    double brightness =
        walls(azimuth_rad, elevation_rad) * textureAt(clutter, azimuth_rad, elevation_rad);
    for (const Clutter::Shape& shape : clutter.shapes) {
      if (covers(shape, azimuth_rad, elevation_rad)) {
        brightness = std::max(brightness, shape.brightness);
      }
    }
    return brightness;
  };
}

}  // namespace bearing_calibration::core
