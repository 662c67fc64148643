#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/panorama.h"
#include "bearing_calibration/simulation/random_numbers.h"

namespace bearing_calibration::core {

/// What may be taken for the light, or hide it. The defaults are those of the scenes on which the
/// detector is measured (detection.md).
struct ClutterConfig {
  CountRange windows{1, 4};      ///< they reach over the upper edge of the view
  CountRange lamps{2, 8};        ///< over the horizon
  CountRange reflections{0, 4};  ///< of windows and lamps, on a shiny floor
  CountRange papers{0, 3};       ///< and doors ajar: pale rectangles under the horizon
  Interval texture_contrast{0.2, 0.6};
  int holders = 3;  ///< of the mirror, spread evenly around it
  Interval holder_half_width_rad{radiansFromDegrees(0.6), radiansFromDegrees(1.2)};

  void declare(Parameters& params);
};

/// What lies on the far surroundings.
struct Clutter {
  /// A bright rectangle, or an ellipse.
  struct Shape {
    double azimuth_rad = 0.0;
    double elevation_rad = 0.0;
    double half_width_rad = 0.0;
    double half_height_rad = 0.0;
    bool is_round = false;
    double brightness = 0.0;  ///< [full wells]
  };
  std::vector<Shape> shapes;

  /// Relative differences of brightness are a sum of waves, 1 on average.
  struct Wave {
    double around = 0.0;  ///< whole waves around the horizon
    double up = 0.0;      ///< [rad/rad]
    double phase_rad = 0.0;
  };
  std::vector<Wave> texture;
  double texture_contrast = 0.0;
};

/// A post that carries the mirror and hides a sector of its image.
struct MirrorHolder {
  double azimuth_rad = 0.0;  ///< in the sensor frame: it turns with the robot
  double half_width_rad = 0.0;
};

Clutter drawClutter(const ClutterConfig& config, SceneRandom* random);
std::vector<MirrorHolder> drawHolders(const ClutterConfig& config, SceneRandom* random);

/// Whether `azimuth_rad` is less than `margin_rad` from a holder's edge, or behind it.
bool isBehind(const std::vector<MirrorHolder>& holders, double azimuth_rad, double margin_rad);

/// `walls` with texture, and with the shapes in front where they are brighter.
RadianceFunction withClutter(const RadianceFunction& walls, const Clutter& clutter);

/// LEDs evenly around a holder, not quite equally bright: their centroid is not its centre.
struct LedRing {
  int leds = 0;  ///< 0: lights stay single balls
  double radius_m = 0.02;
  double brightness_spread = 0.1;  ///< relative standard deviation among the LEDs

  void declare(Parameters& params);
};

/// `light` as a horizontal ring of points around its position, equally bright together on average;
/// `light` itself when the ring has no LEDs.
std::vector<Light> drawLeds(const Light& light, const LedRing& ring, SceneRandom* random);

/// The world around the camera. Parameter groups `world`, `ring`, `surroundings` and `clutter`.
struct SceneConfig {
  std::vector<Light> lights;  ///< their middles, where they are rings
  LedRing ring;
  RoomLook room;
  ClutterConfig clutter;

  void declare(Parameters& params);
};

/// What the camera is shown of it.
struct Scene {
  std::vector<Light> lights;  ///< each LED is one
  RadianceFunction surroundings;
  std::vector<MirrorHolder> holders;
};

/// The same seed gives the same scene. @throws std::invalid_argument with what errorsOf() says.
Scene drawScene(const SceneConfig& config, std::uint64_t seed);

}  // namespace bearing_calibration::core
