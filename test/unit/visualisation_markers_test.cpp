#include "bearing_calibration_ros/visualisation_markers.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <utility>

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;
using visualization_msgs::Marker;

constexpr double kHeight_m = 0.25;
constexpr double kSeparation_m = 0.4;

CalibrationNodeConfig configOf(int most_lights) {
  CalibrationNodeConfig config;
  config.frames.base = "base_link";
  config.output.start_frame = "calibration_start";
  config.calibrator.drive.wheel_separation_m = kSeparation_m;
  config.calibrator.drive.left_wheel_radius_m = 0.1;
  config.calibrator.max_lights = most_lights;
  config.unestimated_mount.z_m = kHeight_m;
  return config;
}

core::Visualisation knownVisualisation() {
  core::Visualisation::Found found;
  found.lights = {{{2.0, 1.0}, {{2.1, 1.0}, {2.0, 1.1}, {1.9, 1.0}, {2.1, 1.0}}, true}};
  found.base_from_sensor = {{0.1, 0.05}, 0.5};
  found.sensor_ellipse_in_base = found.lights[0].ellipse_in_start;
  found.sensor_yaw_band_rad = 0.1;
  core::Visualisation visualisation;
  visualisation.found = found;
  visualisation.ray_in_start = {Eigen::Vector2d(0.1, 0.05), Eigen::Vector2d(2.0, 1.0)};
  visualisation.path_in_start = {{0.0, 0.0}, {0.5, 0.0}, {0.5, 0.5}};
  return visualisation;
}

std::map<std::pair<std::string, int>, Marker> byName(const core::Visualisation& visualisation) {
  std::map<std::pair<std::string, int>, Marker> markers;
  for (const Marker& marker :
       markersFromVisualisation(visualisation, "CONVERGING", configOf(1)).markers) {
    EXPECT_TRUE(markers.emplace(std::pair(marker.ns, marker.id), marker).second)
        << marker.ns << " " << marker.id << " is there twice";
  }
  return markers;
}

TEST(VisualisationMarkers, StandInTheFrameOfWhatTheyShow) {
  const std::set<std::string> carried{"robot", "sensor"};
  for (const auto& [name, marker] : byName(knownVisualisation())) {
    const bool is_carried = carried.count(name.first) != 0;
    EXPECT_EQ(marker.header.frame_id, is_carried ? "base_link" : "calibration_start") << name.first;
    EXPECT_TRUE(marker.frame_locked && marker.header.stamp.isZero()) << name.first;
    EXPECT_EQ(marker.action, Marker::ADD) << name.first;
    EXPECT_GT(marker.color.a, 0.0F) << name.first;
  }
}

TEST(VisualisationMarkers, ShowTheSketchsPoints) {
  auto markers = byName(knownVisualisation());
  const Marker& light = markers.at({"light", 0});
  EXPECT_EQ(light.pose.position.x, 2.0);
  EXPECT_EQ(light.pose.position.y, 1.0);
  EXPECT_EQ(light.pose.position.z, kHeight_m);
  EXPECT_EQ(markers.at({"light", 1}).points.size(), 4U);
  EXPECT_EQ(markers.at({"light", 2}).points.size() % 3, 0U) << "triangles";
  ASSERT_EQ(markers.at({"ray", 0}).points.size(), 2U);
  EXPECT_EQ(markers.at({"ray", 0}).points[1].x, 2.0);
  EXPECT_EQ(markers.at({"path", 0}).points.size(), 3U);
  EXPECT_EQ(markers.at({"robot", 1}).pose.position.y, 0.5 * kSeparation_m);
  EXPECT_EQ(markers.at({"robot", 2}).pose.position.y, -0.5 * kSeparation_m);
  EXPECT_EQ(markers.at({"state", 0}).text, "CONVERGING");
}

TEST(VisualisationMarkers, SeveralLightsHaveThreeMarkersEach) {
  core::Visualisation visualisation = knownVisualisation();
  std::vector<core::Visualisation::Light>& known = visualisation.found->lights;
  known.push_back({{-1.0, 0.5}, known[0].ellipse_in_start, false});
  std::map<int, Marker> lights;
  for (const Marker& marker :
       markersFromVisualisation(visualisation, "CONVERGING", configOf(3)).markers) {
    if (marker.ns == "light") lights[marker.id] = marker;
  }
  ASSERT_EQ(lights.size(), 9U);
  EXPECT_EQ(lights[3].pose.position.x, -1.0);
  EXPECT_EQ(lights[4].points.size(), 4U);
  EXPECT_NE(lights[3].color.r, lights[0].color.r) << "the mount does not rest on it";
  for (int id : {3, 4, 5}) EXPECT_EQ(lights[id].action, Marker::ADD) << id;
  for (int id : {6, 7, 8}) EXPECT_EQ(lights[id].action, Marker::DELETE) << id;
}

TEST(VisualisationMarkers, WhatIsNotKnownIsDeletedUnderTheSameIds) {
  const auto known = byName(knownVisualisation());
  const auto unknown = byName({});
  ASSERT_EQ(known.size(), unknown.size());
  const std::set<std::string> always{"robot", "state"};
  for (const auto& [name, marker] : unknown) {
    EXPECT_EQ(known.count(name), 1U);
    EXPECT_EQ(marker.action, always.count(name.first) != 0 ? Marker::ADD : Marker::DELETE)
        << name.first;
  }
}

}  // namespace
}  // namespace bearing_calibration_ros
