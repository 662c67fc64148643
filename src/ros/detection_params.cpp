#include "bearing_calibration_ros/detection_params.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration_ros {
namespace {

core::ImageSensor readSensor(ParamReader& params) {
  core::ImageSensor sensor;
  sensor.width_px = params.integer("sensor/width");
  sensor.height_px = params.integer("sensor/height");
  sensor.electrons_per_level = params.number("sensor/electrons_per_level");
  sensor.black_level = params.number("sensor/black_level");
  sensor.saturation_level = params.number("sensor/saturation_level");
  sensor.read_noise_electrons = params.number("sensor/read_noise");
  sensor.response_spread = params.number("sensor/response_spread");
  return sensor;
}

core::ConicMirror readMirror(ParamReader& params) {
  core::ConicMirror mirror;
  mirror.focal_length_m = params.number("lens/focal_length");
  mirror.aperture_m = params.number("lens/aperture");
  mirror.focus_distance_m = params.number("lens/focus_distance");
  mirror.pixel_pitch_m = params.number("lens/pixel_pitch");
  mirror.lens_to_apex_m = params.number("mirror/lens_to_apex");
  mirror.half_angle_rad = params.number("mirror/half_angle");
  mirror.base_radius_m = params.number("mirror/base_radius");
  return mirror;
}

core::OpticsUncertainty readOpticsStddev(ParamReader& params) {
  core::OpticsUncertainty stddev;
  stddev.scale = params.number("lens/scale_stddev");
  stddev.aperture = params.number("lens/aperture_stddev");
  stddev.focus = params.number("lens/focus_stddev");
  stddev.half_angle_rad = params.number("mirror/half_angle_stddev");
  return stddev;
}

core::MirrorView readView(ParamReader& params) {
  core::MirrorView view;
  view.centre_u_px = params.number("mirror/centre_u");
  view.centre_v_px = params.number("mirror/centre_v");
  view.handedness = params.integer("mirror/handedness");
  return view;
}

core::MaskConfig readMask(ParamReader& params) {
  core::MaskConfig mask;
  mask.inner_radius_px = params.number("mask/inner_radius");
  mask.outer_radius_px = params.number("mask/outer_radius");
  mask.first_row = params.integer("mask/first_row");
  mask.last_row = params.integer("mask/last_row");
  constexpr std::size_t kPostNumbers = 2;  // azimuth, half width
  for (const std::vector<double>& post : params.rows("mask/posts", kPostNumbers)) {
    mask.posts.push_back({post[0], post[1]});
  }
  return mask;
}

core::LightModel readLight(ParamReader& params) {
  core::LightModel light;
  light.min_distance_m = params.number("light/min_distance");
  light.max_distance_m = params.number("light/max_distance");
  light.min_radius_m = params.number("light/min_radius");
  light.radius_m = params.number("light/radius");
  light.half_height_m = params.number("light/half_height");
  light.brightness_spread = params.number("light/brightness_spread");
  light.max_height_m = params.number("light/max_height");
  return light;
}

core::GateConfig readGates(ParamReader& params) {
  core::GateConfig gates;
  gates.mirror = params.boolean("gates/mirror");
  gates.min_pixels = params.integer("gates/min_pixels");
  gates.max_pixels = params.integer("gates/max_pixels");
  gates.min_probability = params.number("gates/min_probability");
  return gates;
}

core::DetectorConfig readDetector(ParamReader& params) {
  core::DetectorConfig detector;
  detector.sensor = readSensor(params);
  detector.mirror = readMirror(params);
  detector.optics_stddev = readOpticsStddev(params);
  detector.view = readView(params);
  detector.mask = readMask(params);
  detector.threshold.min_contrast_levels = params.number("threshold/min_contrast");
  detector.threshold.spreads = params.number("threshold/spreads");
  detector.light = readLight(params);
  detector.gates = readGates(params);
  detector.alignment.centre_stddev_px = params.number("alignment/centre_stddev");
  detector.alignment.geometry = {params.number("alignment/harmonic_stddev"),
                                 params.number("alignment/near_per_far"),
                                 params.number("alignment/nearness_stddev")};
  detector.alignment.elevation_stddev_rad = params.number("alignment/elevation_stddev");
  detector.defocus_sigma_px = params.number("defocus/sigma");
  detector.max_candidates = params.integer("gates/max_candidates");
  return detector;
}

core::ShutterConfig readShutter(ParamReader& params) {
  core::ShutterConfig shutter;
  shutter.stamp_to_mid_exposure_s = params.number("time/stamp_to_mid_exposure");
  shutter.row_time_s = params.number("time/row_time");
  shutter.max_turn_rate_radps = params.number("time/max_turn_rate");
  return shutter;
}

core::SearchConfig readSearch(ParamReader& params) {
  core::SearchConfig search;
  search.use = params.boolean("prediction/use");
  search.sigmas = params.number("prediction/sigmas");
  search.margin_rad = params.number("prediction/margin");
  search.max_half_width_rad = params.number("prediction/max_half_width");
  search.max_age_s = params.number("prediction/max_age");
  search.max_radius_rate_pxps = params.number("prediction/max_radius_rate");
  search.max_turn_rate_radps = params.number("time/max_turn_rate");
  return search;
}

core::BlinkConfig readBlink(ParamReader& params) {
  core::BlinkConfig blink;
  blink.use = params.boolean("blink/use");
  blink.rate_hz = params.number("blink/rate");
  blink.window_s = params.number("blink/window");
  blink.min_part_at_rate = params.number("blink/min_part_at_rate");
  blink.max_turn_rate_radps = params.number("time/max_turn_rate");
  blink.light_id = params.integer("blink/light_id");
  return blink;
}

/// 0 on error.
std::int32_t lightId(double number, ParamReader& params) {
  constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
  if (number >= 0.0 && number <= kLargest && number == std::floor(number)) {
    return static_cast<std::int32_t>(number);
  }
  std::ostringstream text;
  text << "colour/lights: a light_id must be a whole number from 0 to " << kLargest
       << ", but one is " << number;
  params.addError(text.str());
  return 0;
}

core::ColourConfig readColour(ParamReader& params) {
  core::ColourConfig colour;
  colour.use = params.boolean("colour/use");
  colour.tolerance = params.number("colour/tolerance");
  constexpr std::size_t kNumbers = 4;  // light_id, red, green, blue
  for (const std::vector<double>& light : params.rows("colour/lights", kNumbers)) {
    colour.lights.push_back({lightId(light[0], params), {light[1], light[2], light[3]}});
  }
  return colour;
}

std::vector<std::string> nodeErrors(const DetectionNodeConfig& config) {
  constexpr int kLongestQueue = 1000;  // of 640x480: 300 MB
  core::Requirements require;
  require.that(!config.sensor_frame.empty(), "frames/sensor must not be empty");
  require.between("images/queue", config.image_queue, 1, kLongestQueue);
  require.that(!(config.blink.use && config.colour.use),
               "blink/use and colour/use cannot both be set: one of them names the light");
  require.between("prediction/full_scan_every", config.full_scan_every, 1,
                  core::plausible::kMostOfAKind);
  return require.errors();
}

}  // namespace

DetectionNodeConfig readDetectionNodeConfig(ParamReader params) {
  DetectionNodeConfig config;
  config.sensor_frame = params.text("frames/sensor");
  config.camera_info_required = params.boolean("camera_info/required");
  config.image_queue = params.integer("images/queue");
  config.detector = readDetector(params);
  config.shutter = readShutter(params);
  config.search = readSearch(params);
  config.blink = readBlink(params);
  config.colour = readColour(params);
  config.full_scan_every = params.integer("prediction/full_scan_every");
  params.addErrors(config.detector.validate());
  params.addErrors(config.shutter.validate());
  params.addErrors(config.search.validate());
  params.addErrors(config.blink.validate());
  params.addErrors(config.colour.validate());
  params.addErrors(nodeErrors(config));
  params.throwIfAnyError();
  return config;
}

}  // namespace bearing_calibration_ros
