#include "tools/clutter_scene.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/simulation/pixel_noise.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration {
namespace {

using Random = std::mt19937_64;

double between(Random* random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*random);
}

/// A bright shape on the far surroundings: a rectangle, or an ellipse.
struct Shape {
  double azimuth_rad;
  double elevation_rad;
  double half_width_rad;
  double half_height_rad;
  bool round;
  double brightness;  ///< [full wells]

  bool covers(double azimuth, double elevation) const {
    const double x = wrapAngle(azimuth - azimuth_rad) / half_width_rad;
    const double y = (elevation - elevation_rad) / half_height_rad;
    return round ? x * x + y * y <= 1.0 : std::abs(x) <= 1.0 && std::abs(y) <= 1.0;
  }
};

Shape randomShape(Random* random, const Range& elevation_deg, const Range& half_width_deg,
                  const Range& half_height_deg, bool round, const Range& brightness) {
  const auto radians = [&](const Range& range) {
    return radiansFromDegrees(between(random, range.low, range.high));
  };
  Shape shape{};
  shape.azimuth_rad = between(random, -kPi, kPi);
  shape.elevation_rad = radians(elevation_deg);
  shape.half_width_rad = radians(half_width_deg);
  shape.half_height_rad = radians(half_height_deg);
  shape.round = round;
  shape.brightness = between(random, brightness.low, brightness.high);
  return shape;
}

/// Windows, lamps, and their reflections on a shiny floor. The rig sees from -15 to +3 degrees.
std::vector<Shape> randomShapes(Random* random) {
  const auto count = [&](int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(*random);
  };
  std::vector<Shape> shapes;
  for (int i = count(1, 4); i > 0; --i) {  // windows reach over the upper edge of the view
    shapes.push_back(randomShape(random, {0.0, 5.0}, {2.0, 20.0}, {2.0, 6.0}, false, {0.3, 3.0}));
  }
  for (int i = count(2, 8); i > 0; --i) {  // lamps
    shapes.push_back(randomShape(random, {0.3, 3.0}, {0.7, 3.0}, {0.5, 1.5}, true, {0.4, 4.0}));
  }
  for (int i = count(0, 4); i > 0; --i) {  // reflections
    shapes.push_back(randomShape(random, {-12.0, -1.0}, {0.5, 3.0}, {0.8, 4.0}, true, {0.15, 0.9}));
  }
  for (int i = count(0, 3); i > 0; --i) {  // sheets of paper, doors ajar
    shapes.push_back(
        randomShape(random, {-12.0, -1.0}, {0.5, 6.0}, {0.5, 4.0}, false, {0.15, 0.6}));
  }
  return shapes;
}

/// Smooth relative differences of brightness at several scales, 1 on average.
class Texture {
 public:
  explicit Texture(Random* random) : contrast_(between(random, 0.2, 0.6)) {
    constexpr int kWaves = 24;
    for (int i = 0; i < kWaves; ++i) {
      const double around = std::round(between(random, 1.0, 60.0));  // whole waves around
      waves_.push_back({around, between(random, -80.0, 80.0), between(random, -kPi, kPi)});
    }
  }
  double at(double azimuth_rad, double elevation_rad) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) {
      sum += std::sin(wave.around * azimuth_rad + wave.up * elevation_rad + wave.phase);
    }
    const double stddev = std::sqrt(0.5 * static_cast<double>(waves_.size()));
    return std::max(0.0, 1.0 + contrast_ * sum / stddev);
  }

 private:
  struct Wave {
    double around;
    double up;
    double phase;
  };
  double contrast_;
  std::vector<Wave> waves_;
};

/// Three holders a third of a turn apart, 1.2 to 2.4 degrees wide; masked with a degree more.
std::vector<MirrorPost> randomPosts(Random* random) {
  constexpr int kPosts = 3;
  const double first_rad = between(random, -kPi, kPi);
  const double half_width_rad = radiansFromDegrees(between(random, 0.6, 1.2));
  std::vector<MirrorPost> posts;
  for (int i = 0; i < kPosts; ++i) {
    posts.push_back({wrapAngle(first_rad + 2.0 * kPi * i / kPosts), half_width_rad});
  }
  return posts;
}

bool near(const std::vector<MirrorPost>& posts, double azimuth_rad, double margin_rad) {
  return std::any_of(posts.begin(), posts.end(), [&](const MirrorPost& post) {
    return std::abs(wrapAngle(azimuth_rad - post.azimuth_rad)) < post.half_width_rad + margin_rad;
  });
}

constexpr double kMaskMargin_rad = 1.0 / kDegreesPerRadian;
constexpr double kHalfSpot_rad = 2.2 / kDegreesPerRadian;  // 6 px at an image radius of 160 px

Light randomLight(Random* random, const RendererConfig& rendered, double azimuth_rad) {
  const double distance_m = std::exp(between(random, std::log(0.3), std::log(4.0)));
  const double peak_levels = between(random, 90.0, 400.0);
  Light light;
  light.position_m = distance_m * Eigen::Vector2d(std::cos(azimuth_rad), std::sin(azimuth_rad));
  light.height_m = rendered.reference_height_m;
  light.brightness = peak_levels / rendered.reference_value *
                     std::pow(distance_m / rendered.reference_distance_m, 2);
  return light;
}

void darkenPosts(const CameraRig& rig, const std::vector<MirrorPost>& posts,
                 std::vector<float>* electrons) {
  constexpr float kLeft = 0.03F;  // a post is nearly black
  const MirrorView view{rig.centre_px.x(), rig.centre_px.y(), rig.handedness};
  for (std::size_t i = 0; i < electrons->size(); ++i) {
    const int u = static_cast<int>(i) % rig.width_px;
    const int v = static_cast<int>(i) / rig.width_px;
    if (near(posts, mirrorPixelFromImage(view, u, v).azimuth_rad, 0.0)) (*electrons)[i] *= kLeft;
  }
}

}  // namespace

ClutterScene clutterScene(const ClutterConfig& config, std::uint64_t seed) {
  Random random(seed);
  const std::vector<Shape> shapes = randomShapes(&random);
  const Texture texture(&random);
  const double wall = between(&random, 0.03, 0.15);
  ImageRenderer renderer(config.rendered, [&](double azimuth_rad, double elevation_rad) {
    double brightness = wall * texture.at(azimuth_rad, elevation_rad);
    for (const Shape& shape : shapes) {
      if (shape.covers(azimuth_rad, elevation_rad))
        brightness = std::max(brightness, shape.brightness);
    }
    return brightness;
  });

  ClutterScene scene;
  scene.posts = randomPosts(&random);
  std::vector<Light> lights;
  while (static_cast<int>(lights.size()) < config.lights) {
    const double azimuth_rad = between(&random, -kPi, kPi);
    if (near(scene.posts, azimuth_rad, kMaskMargin_rad + kHalfSpot_rad)) continue;
    if (lights.empty()) scene.light_azimuth_rad = azimuth_rad;
    lights.push_back(randomLight(&random, config.rendered, azimuth_rad));
  }
  std::vector<float> electrons = renderer.expose(lights, Pose2());
  darkenPosts(config.rendered.rig, scene.posts, &electrons);
  std::vector<std::uint8_t> values;
  PixelNoise(config.rendered.pixels, seed).digitize(electrons, seed, &values);
  const CameraRig& rig = config.rendered.rig;
  scene.image = cv::Mat(rig.height_px, rig.width_px, CV_8UC1, values.data()).clone();
  for (MirrorPost& post : scene.posts) post.half_width_rad += kMaskMargin_rad;
  return scene;
}

}  // namespace bearing_calibration
