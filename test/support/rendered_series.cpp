#include "support/rendered_series.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace test {
namespace {

constexpr double kTurn_radps = 1.0;
constexpr double kExposure_s = 5e-3;
constexpr double kRowTime_s = 30e-6;  // 14 ms for 480 rows: a webcam's order
constexpr int kJpegQuality = 90;
constexpr double kBright = 5.7;  // peaks at four times the full well

RenderedSeries point(const std::string& name) {
  RenderedSeries series;
  series.name = name;
  series.rendered = renderedRig();
  series.detector = detectorOf(series.rendered);
  series.detector.threshold = shippedDetector().threshold;
  return series;
}

RenderedSeries turning(const std::string& name, double exposure_s, double row_time_s) {
  RenderedSeries series = point(name);
  series.turn_radps = kTurn_radps;
  series.rendered.shutter = {exposure_s, row_time_s};
  series.shutter.row_time_s = row_time_s;
  return series;
}

RenderedSeries ringOfLeds(const std::string& name, double brightness_spread) {
  constexpr double kRadius_m = 0.02;
  constexpr int kLeds = 8;
  RenderedSeries series = point(name);
  series.rendered.rays_per_light = 1 << 13;  // for each LED
  series.ring = {kLeds, kRadius_m, brightness_spread};
  series.detector.light.min_radius_m = kRadius_m;
  series.detector.light.radius_m = kRadius_m;
  series.detector.light.brightness_spread = brightness_spread;
  return series;
}

RenderedSeries encoded(const std::string& name, const ImageEncoding& encoding) {
  RenderedSeries series = point(name);
  series.rendered.encoding = encoding;
  return series;
}

/// The same optics on a sensor of twice as many, half as large pixels each way.
RenderedSeries finer(const std::string& name) {
  RenderedSeries series = point(name);
  CameraRig& rig = series.rendered.rig;
  rig.width_px = 1280;
  rig.height_px = 1024;
  rig.centre_px = {639.5, 511.5};
  rig.pixel_m *= 0.5;
  series.rendered.rays_per_light *= 2;  // keeps their grain below the noise of smaller pixels
  series.rendered.centre_radius_px *= 2.0;
  series.detector = detectorOf(series.rendered);
  series.detector.mirror.pixel_pitch_m *= 0.5;
  series.detector.sensor.width_px = rig.width_px;
  series.detector.sensor.height_px = rig.height_px;
  series.detector.mask.inner_radius_px *= 2.0;
  series.detector.mask.outer_radius_px *= 2.0;
  series.detector.mask.last_row = rig.height_px - 1;
  return series;
}

/// The image as a driver's message and the node's conversion give it to the detector.
class Camera {
 public:
  explicit Camera(const RenderedSeries& series)
      : encoding_(series.rendered.encoding),
        renderer_(series.rendered, plainWall),
        ring_(series.ring),
        random_(series.rendered.seed) {}

  const cv::Mat& photograph(const Light& light, const SensorMotion& motion, std::size_t number) {
    const cv::Mat image = renderer_.render(drawLeds(light, ring_, &random_), motion, number);
    const std::string& name = layoutNames()[static_cast<std::size_t>(encoding_.layout)];
    return converter_.convert(
        bearing_calibration_ros::imageMessage({}, name, encode(image, encoding_)));
  }

 private:
  ImageEncoding encoding_;
  ImageRenderer renderer_;
  LedRing ring_;
  SceneRandom random_;
  bearing_calibration_ros::GreyConverter converter_;
};

}  // namespace

std::vector<RenderedSeries> renderedSeries() {
  using Layout = ImageEncoding::Layout;
  std::vector<RenderedSeries> all{point("point")};
  all.push_back(point("saturated"));
  all.back().brightness = kBright;
  all.push_back(ringOfLeds("ring, 10 % unequal", 0.1));
  all.push_back(ringOfLeds("ring, 30 % unequal", 0.3));
  all.push_back(turning("motion blur", kExposure_s, 0.0));
  all.push_back(turning("rolling shutter", 0.0, kRowTime_s));
  all.push_back(turning("rolling shutter and motion blur", kExposure_s, kRowTime_s));
  all.push_back(turning("rolling shutter, not told", 0.0, kRowTime_s));
  all.back().shutter.row_time_s = 0.0;
  all.push_back(encoded("JPEG", {Layout::kMono8, kJpegQuality, 1.0, 1.0}));
  all.push_back(encoded("bayer_rggb8, white balanced", {Layout::kBayerRggb8, 0, 1.0, 1.0}));
  all.push_back(encoded("bayer_rggb8, red 0.7, blue 0.6", {Layout::kBayerRggb8, 0, 0.7, 0.6}));
  all.push_back(encoded("bgr8", {Layout::kBgr8, 0, 1.0, 1.0}));
  all.push_back(finer("1280x1024"));
  return all;
}

RenderedSeries renderedSeries(const std::string& name) {
  for (const RenderedSeries& series : renderedSeries()) {
    if (series.name == name) return series;
  }
  throw std::out_of_range("there is no series '" + name + "'");
}

BearingErrors errorsOf(const RenderedSeries& series, int images, unsigned seed) {
  return errorsOf(series, randomObservations(images, series.brightness, seed));
}

BearingErrors errorsOf(const RenderedSeries& series, const std::vector<Observation>& observations) {
  Camera camera(series);
  LightDetector detector(series.detector);
  const Stamp stamp = stampFromSeconds(1.0);
  BearingErrors errors;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const SensorMotion motion{observations[i].worldFromSensor(), Eigen::Vector2d::Zero(),
                              series.turn_radps};
    const cv::Mat& image = camera.photograph(observations[i].light(), motion, i);
    const DetectionResult& result = detector.detect(image);
    if (result.lights.size() != 1) continue;
    const BearingSet set =
        bearingsFromLights(result.lights, series.shutter, stamp, series.rendered.rig.height_px);
    const Pose2 pose = motion.poseAt(secondsFromDuration(set.stamp - stamp));
    errors.add(set.candidates.front(), azimuthOf(observations[i].light(), pose));
  }
  return errors;
}

}  // namespace test
}  // namespace bearing_calibration::core
