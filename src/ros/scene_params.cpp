#include "bearing_calibration_ros/scene_params.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace bearing_calibration_ros {
namespace {

core::CameraRig readRig(ParamReader& params) {
  core::CameraRig rig;
  rig.width_px = params.integer("camera/width");
  rig.height_px = params.integer("camera/height");
  rig.centre_px.x() = params.number("camera/centre_u");
  rig.centre_px.y() = params.number("camera/centre_v");
  rig.pixel_m = params.number("camera/pixel");
  rig.focal_length_m = params.number("camera/focal_length");
  rig.aperture_m = params.number("camera/aperture");
  rig.focus_distance_m = params.number("camera/focus_distance");
  rig.handedness = params.integer("camera/handedness");
  rig.lens_to_apex_m = params.number("mirror/lens_to_apex");
  rig.cone_half_angle_rad = params.number("mirror/cone_half_angle");
  rig.mirror_radius_m = params.number("mirror/radius");
  rig.axis_lean.x() = params.number("mirror/lean_x");
  rig.axis_lean.y() = params.number("mirror/lean_y");
  rig.apex_offset_m.x() = params.number("mirror/offset_x");
  rig.apex_offset_m.y() = params.number("mirror/offset_y");
  return rig;
}

core::ImageEncoding readEncoding(ParamReader& params) {
  core::ImageEncoding encoding;
  encoding.layout = static_cast<core::ImageEncoding::Layout>(
      params.choice("camera/encoding", core::layoutNames()));
  encoding.jpeg_quality = params.integer("camera/jpeg_quality");
  encoding.red_response = params.number("camera/red_response");
  encoding.blue_response = params.number("camera/blue_response");
  return encoding;
}

core::CountRange readCounts(ParamReader& params, const std::string& name) {
  const std::vector<double> range = params.numbers(name, 2);
  const bool is_whole = std::all_of(range.begin(), range.end(), [](double number) {
    return std::isnan(number) || number == std::clamp(std::round(number), 0.0, 1e6);
  });
  if (!is_whole) params.addError("parameter " + name + " must hold two whole numbers");
  if (!is_whole || std::isnan(range[0])) return {};
  return {static_cast<int>(range[0]), static_cast<int>(range[1])};
}

core::Interval readInterval(ParamReader& params, const std::string& name) {
  const std::vector<double> range = params.numbers(name, 2);
  return {range[0], range[1]};
}

core::ClutterConfig readClutter(ParamReader& params) {
  core::ClutterConfig clutter;
  clutter.windows = readCounts(params, "clutter/windows");
  clutter.lamps = readCounts(params, "clutter/lamps");
  clutter.reflections = readCounts(params, "clutter/reflections");
  clutter.papers = readCounts(params, "clutter/papers");
  clutter.texture_contrast = readInterval(params, "clutter/texture_contrast");
  clutter.holders = params.integer("clutter/holders");
  clutter.holder_half_width_rad = readInterval(params, "clutter/holder_half_width");
  return clutter;
}

std::vector<core::Light> readLights(ParamReader& params) {
  std::vector<core::Light> lights;
  for (const auto& row : params.rows("world/lights", 5)) {
    lights.push_back({{row[0], row[1]}, row[2], row[3], row[4]});
  }
  return lights;
}

}  // namespace

core::RendererConfig readRenderer(ParamReader& params, std::uint64_t seed) {
  core::RendererConfig renderer;
  renderer.rig = readRig(params);
  renderer.pixels.full_well_electrons = params.number("camera/full_well");
  renderer.pixels.read_noise_electrons = params.number("camera/read_noise");
  renderer.shutter.exposure_s = params.number("camera/exposure_time");
  renderer.shutter.row_time_s = params.number("camera/row_time");
  renderer.encoding = readEncoding(params);
  renderer.rays_per_light = params.integer("camera/rays_per_light");
  renderer.reference_value = params.number("exposure/reference_value");
  renderer.reference_distance_m = params.number("exposure/reference_distance");
  renderer.reference_height_m = params.number("exposure/reference_height");
  renderer.outside_mirror = params.number("surroundings/outside_mirror");
  renderer.centre_radius_px = params.number("surroundings/centre_radius");
  renderer.centre_brightness = params.number("surroundings/centre_brightness");
  renderer.seed = seed;
  return renderer;
}

core::SceneConfig readScene(ParamReader& params, std::uint64_t seed) {
  core::SceneConfig scene;
  scene.lights = readLights(params);
  scene.ring.leds = params.integer("ring/leds");
  scene.ring.radius_m = params.number("ring/radius");
  scene.ring.brightness_spread = params.number("ring/brightness_spread");
  scene.room = {params.number("surroundings/brightness"), params.number("surroundings/contrast"),
                seed};
  scene.clutter = readClutter(params);
  return scene;
}

}  // namespace bearing_calibration_ros
