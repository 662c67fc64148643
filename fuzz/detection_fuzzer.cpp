#include "fuzz/detection_fuzzer.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/mirror_rim.h"
#include "bearing_calibration/vision/optics_learner.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/rig_checks.h"
#include "fuzz/bearing_check.h"
#include "fuzz/harness.h"
#include "fuzz/image_input.h"

namespace bearing_calibration_ros {
namespace {

using bearing_calibration::fuzz::ByteReader;
using bearing_calibration::fuzz::require;

enum Kind : std::uint8_t {
  kMirror = 3,  ///< cone, cone, another, none
  kBlinks = 4,
  kColoured = 8,
  kDefocus = 16,
  kPost = 32,
  kFisheye = 64,
  kFaint = 128
};

/// The simulated robot's, as shipped.
const DetectionNodeConfig& shipped() {
  const std::string folder = BEARING_CALIBRATION_CONFIG_FOLDER "/";
  static const auto config = readConfig<DetectionNodeConfig>(ParamReader(
      parametersFromFiles({folder + "detection.yaml", folder + "robots/simulated.yaml"})));
  return config;
}

core::MirrorKind mirrorOf(std::uint8_t kind) {
  if ((kind & kMirror) == kMirror) return core::MirrorKind::kNone;
  return (kind & kMirror) == 2 ? core::MirrorKind::kOther : core::MirrorKind::kCone;
}

/// Both cannot be set, and stand for a sensor of 16 bits.
bool isDeep(std::uint8_t kind) { return (kind & kBlinks) != 0 && (kind & kColoured) != 0; }

/// The shipped configuration with pixels so large that all of the mirror is in the image, if that
/// is not too small.
DetectionNodeConfig rigFor(std::uint8_t kind, const sensor_msgs::Image& image) {
  DetectionNodeConfig config = shipped();
  core::DetectorConfig& detector = config.detector;
  constexpr double kSmallest = 0.25;
  const double scale =
      std::clamp(static_cast<double>(image.width) / detector.sensor.width_px, kSmallest, 1.0);
  detector.mirror.pixel_pitch_m /= scale;
  detector.mask.inner_radius_px *= scale;
  detector.mask.outer_radius_px *= scale;
  detector.sensor.width_px = static_cast<int>(image.width);
  detector.sensor.height_px = static_cast<int>(image.height);
  detector.view.centre_u_px = 0.5 * (detector.sensor.width_px - 1.0);
  detector.view.centre_v_px = 0.5 * (detector.sensor.height_px - 1.0);
  detector.mask.last_row = detector.sensor.height_px - 1;
  detector.mirror_kind = mirrorOf(kind);
  config.colour.use = (kind & kColoured) != 0;
  config.blink.use = !config.colour.use && (kind & kBlinks) != 0;
  // A rate that a few images tell.
  config.blink.rate_hz = 2.0;
  config.blink.window_s = 1.5;
  constexpr double kDeepest = 65535.0;  // of 16 bits
  if (isDeep(kind)) detector.sensor.saturation_level = kDeepest;
  config.colour.lights = {{1, {1.0, 1.0, 1.0}}, {2, {1.0, 0.1, 0.1}}};
  if ((kind & kDefocus) != 0) detector.defocus_sigma_px = 1.5;
  if ((kind & kPost) != 0) detector.mask.posts = {{1.0, 0.1}};
  if ((kind & kFaint) != 0) detector.threshold.min_contrast_levels = 1.0;
  return config;
}

/// Of all inputs, each of which is up to 36 of them.
struct ImageCount {
  std::size_t images = 0;
  ~ImageCount() { std::fprintf(stderr, "images that lights were detected in: %zu\n", images); }
};

core::Camera cameraOf(std::uint8_t kind, const core::MirrorView& view) {
  constexpr double kFocal_px = 150.0;
  core::Camera camera;
  camera.focal_u_px = camera.focal_v_px = kFocal_px;
  camera.centre_u_px = view.centre_u_px;
  camera.centre_v_px = view.centre_v_px;
  if ((kind & kFisheye) != 0) camera.lens = core::Lens::kFisheye;
  return camera;
}

void requireOptics(const core::OpticsLearner& learner, const core::DetectorConfig& configured) {
  for (const core::LearntOptics& value : learner.optics()) {
    require(std::isfinite(value.value) && std::isfinite(value.stddev) && value.stddev > 0.0,
            "what is learnt of the optics is no number");
    require(std::strlen(core::nameOf(value.state)) > 0, "how a value is known has no name");
  }
  require(core::errorsOf(learner.applied(configured)).empty(), "the optics learnt are refused");
  const std::string yaml = core::yamlOf(learner);
  require(!yaml.empty(), "the optics learnt cannot be written");
  require(learner.learntValuesIn(yaml) == learner.learntValues(),
          "of the optics written more or fewer are learnt than of those that were to be");
}

void requireMeaning(const core::BearingSet& bearings) {
  for (const core::Bearing& bearing : bearings.candidates) {
    bearing_calibration::fuzz::requireBearing(bearing);
    require(!(bearing.track_probability < 0.0 || bearing.track_probability > 1.0),
            "a track's probability is not in [0, 1]");
  }
}

/// Lights at known distances, one after the other, whatever they look like.
bool learn(ByteReader* bytes) {
  const core::DetectorConfig& config = shipped().detector;
  core::OpticsLearner learner(config);
  core::Stamp stamp = core::stampFromSeconds(1.0);
  bool is_used = false;
  while (!bytes->isEmpty()) {
    stamp += core::durationFromSeconds(bytes->between(-0.1, 2.0));
    constexpr int kMisses = 8;
    if (bytes->byte() % kMisses == 0) {
      learner.miss(stamp);
      continue;
    }
    core::RangedSpot spot;
    spot.stamp = stamp;
    spot.azimuth_rad = bytes->between(-core::kPi, core::kPi);
    spot.image_radius_px = bytes->between(0.0, 400.0);
    spot.variances_px2 = {bytes->between(0.01, 60.0), bytes->between(0.01, 60.0)};
    spot.distance_m = bytes->between(0.05, 12.0);
    spot.distance_variance_m2 = std::pow(bytes->between(1e-4, 0.5), 2);
    is_used |= learner.add(spot);
    learner.hasNews();
  }
  requireOptics(learner, config);
  return is_used;
}

/// As a driver sends it that compresses, or cuts short what it has compressed.
/// @return whether it is an image afterwards
bool compress(std::uint8_t flags, sensor_msgs::Image* image) {
  const int columns = static_cast<int>(image->step);
  const int rows = static_cast<int>(image->height);
  const std::size_t needed = static_cast<std::size_t>(columns) * image->height;
  constexpr int kWidest = 16384;  // that a sensor may be
  if (image->data.empty() || image->data.size() != needed || columns > kWidest) return false;
  const bool is_wide = (flags & 8U) != 0 && columns % 3 == 0;
  const cv::Mat pixels(rows, is_wide ? columns / 3 : columns, is_wide ? CV_8UC3 : CV_8UC1,
                       image->data.data());
  sensor_msgs::CompressedImage compressed;
  compressed.header = image->header;
  compressed.format = image->encoding + "; png compressed";
  cv::imencode(".png", pixels, compressed.data);
  if ((flags & 16U) != 0) compressed.data.resize(compressed.data.size() / 2);
  if (const sensor_msgs::ImagePtr sent = decoded(compressed)) {
    *image = *sent;
    return true;
  }
  require(!describeUndecoded(compressed).empty(), "what cannot be read says nothing");
  return false;
}

/// Several pictures in turn, a few times.
bool watch(std::uint8_t kind, const std::uint8_t* data, std::size_t size) {
  ByteReader head(data, size);
  const std::uint8_t pictures = head.byte() % 4 + 1;
  const std::uint8_t rounds = head.byte() % 9 + 1;
  const std::uint8_t flags = head.byte();
  core::BearingPrediction prediction;
  prediction.azimuth_rad = head.between(-core::kPi, core::kPi);
  prediction.azimuth_variance_rad2 = std::pow(head.between(0.001, 0.5), 2);
  prediction.distance_m = head.between(0.1, 10.0);
  prediction.distance_variance_m2 = std::pow(0.01 * prediction.distance_m, 2);
  constexpr std::size_t kHead = 9;
  const std::size_t share = size > kHead ? (size - kHead) / pictures : 0;
  DetectionFuzzer node(kind);
  bool is_any = false;
  for (int i = 0; i < rounds * pictures; ++i) {
    ByteReader bytes(data + std::min(size, kHead + share * (i % pictures)), share);
    sensor_msgs::Image image = imageFrom(&bytes);
    if (!image.header.stamp.isZero()) image.header.stamp += ros::Duration(0.1 * i);
    if ((flags & 4U) != 0 && !compress(flags, &image)) continue;
    prediction.stamp = stampFromRos(image.header.stamp);
    const bool is_expected = (flags & 1U) != 0;
    is_any |= node.see(image, is_expected ? std::optional(prediction) : std::nullopt);
  }
  node.takeAdvice();
  if (is_any && (flags & 2U) != 0) node.findMirrorInIt();
  return is_any;
}

}  // namespace

bool DetectionFuzzer::see(const sensor_msgs::Image& image,
                          const std::optional<core::BearingPrediction>& prediction) {
  if (!bearings_) config_ = rigFor(kind_, image);
  if (const auto refusal = refusalOf(image, config_.detector.sensor)) {
    require(!refusal->kind.empty() && !refusal->text.empty(), "a refusal says nothing");
    return false;
  }
  if (!bearings_) bearings_.emplace(config_);
  if (config_.detector.mirror_kind == core::MirrorKind::kNone) {
    bearings_->setCamera(cameraOf(kind_, config_.detector.view));
  }
  try {
    requireMeaning(bearings_->detect(boost::make_shared<sensor_msgs::Image>(image), prediction));
  } catch (const std::invalid_argument&) {
    require(config_.colour.use && !hasColours(image.encoding), "a sound image is refused");
    return false;
  }
  static ImageCount count;
  ++count.images;
  const core::DetectionResult& result = bearings_->result();
  advice_.add(core::adviceFor(config_.detector, result));
  core::annotate(bearings_->grey(), result, config_.detector);
  if (const auto& learner = bearings_->learner()) requireOptics(*learner, config_.detector);
  return true;
}

void DetectionFuzzer::takeAdvice() {
  if (const auto advice = advice_.take()) {
    require(!advice->sentence.empty(), "advice says nothing");
  }
}

void DetectionFuzzer::findMirrorInIt() const {
  const msg::FindMirrorResponse answer = findMirror(bearings_->grey(), config_.detector);
  require(!answer.text.empty(), "an answer says nothing");
  require(!answer.found || (std::isfinite(answer.centre_u) && std::isfinite(answer.centre_v) &&
                            answer.radius > 0.0),
          "a mirror's rim is no circle");
  const cv::Mat& image = bearings_->grey();
  if (const auto rim = core::findMirrorRim(image, core::rimSearchIn(image))) {
    core::annotateRim(image, *rim);
  }
}

}  // namespace bearing_calibration_ros

bool bearing_calibration::fuzz::run(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint8_t kLearns = 255;
  if (size == 0) return false;
  if (*data != kLearns) return bearing_calibration_ros::watch(*data, data + 1, size - 1);
  ByteReader bytes(data + 1, size - 1);
  return bearing_calibration_ros::learn(&bytes);
}
