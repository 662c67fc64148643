// What the adapter of bearings is sent: a laser scan, or a point in a frame of its own. What comes
// out is a bearing, or a word.

#include <console_bridge/console.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/input/point_bearing.h"
#include "bearing_calibration/input/scan_bearings.h"
#include "bearing_calibration_ros/adapter_params.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/sensor_places.h"
#include "fuzz/bearing_check.h"
#include "fuzz/byte_reader.h"
#include "fuzz/harness.h"

namespace bearing_calibration::fuzz {
namespace {

namespace ros_side = bearing_calibration_ros;

constexpr double kStddev_rad = 0.01;

/// As a scanner sends them: too far, or odd, or of everyday size.
float drawFloat(ByteReader* bytes, double most) {
  if (!bytes->flag()) return static_cast<float>(bytes->between(0.0, most));
  const double any = bytes->anyNumber();
  const bool fits = !(std::abs(any) > static_cast<double>(std::numeric_limits<float>::max()));
  return fits ? static_cast<float>(any) : std::numeric_limits<float>::infinity();
}

sensor_msgs::LaserScan drawScan(ByteReader* bytes) {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = ros::Time(bytes->byte(), 0);
  scan.time_increment = drawFloat(bytes, 0.001);
  scan.angle_min = drawFloat(bytes, 1.0);
  scan.angle_increment = drawFloat(bytes, 0.1);
  scan.range_min = drawFloat(bytes, 0.1);
  scan.range_max = drawFloat(bytes, 10.0);
  const bool has_intensities = bytes->flag();
  while (!bytes->isEmpty()) {
    scan.ranges.push_back(drawFloat(bytes, 10.0));
    if (has_intensities) scan.intensities.push_back(drawFloat(bytes, 1.0));
  }
  return scan;
}

/// A parameter as somebody may write it.
std::string drawParameter(ByteReader* bytes, double most) {
  const double number = bytes->flag() ? bytes->anyNumber() : bytes->between(0.0, most);
  return core::formatted("%g", number);
}

/// What the node makes of its parameters; none where it refuses them.
std::optional<core::ScanLightConfig> drawConfig(ByteReader* bytes) {
  std::string text = "frames: {sensor: sensor";
  if (bytes->flag()) text += "_optical";  // is refused
  text += "}\nbearings: {source: scan, azimuth_stddev: 0.01, light_id: -1}\nscan: {min_intensity: ";
  text += drawParameter(bytes, 1.0);
  text += ", min_jump: " + drawParameter(bytes, 1.0);
  text += ", min_width: " + drawParameter(bytes, 0.1);
  text += ", max_width: " + drawParameter(bytes, 1.0) + "}\n";
  ros_side::AdapterNodeConfig config;
  try {
    ros_side::ParamReader params(ros_side::parametersFromYaml(text, "parameters"));
    config.declare(params);
    params.throwIfAnyError();
  } catch (const std::runtime_error& error) {
    require(*error.what() != '\0', "an error says nothing");
    return std::nullopt;
  }
  return config.scan;
}

bool runScan(ByteReader* bytes) {
  const std::optional<core::ScanLightConfig> config = drawConfig(bytes);
  if (!config) return false;
  std::optional<core::BearingPrediction> prediction;
  if (bytes->flag()) {
    prediction =
        core::BearingPrediction{core::stampFromSeconds(bytes->byte()), bytes->anyNumber(), 0.01};
  }
  const core::LaserScan scan = ros_side::scanFromMessage(drawScan(bytes));
  if (!core::whyUnusable(scan, *config).empty()) return false;
  const std::vector<core::ScanLight> lights = core::lightsInScan(scan, *config);
  for (const core::ScanLight& light : lights) {
    require(light.position_m.allFinite() && light.rays > 0, "a light in a scan is nowhere");
    require(light.stamp >= scan.stamp, "a light was measured before its scan");
  }
  const core::BearingSet set =
      core::bearingsInScan(scan, *config, Eigen::Isometry3d::Identity(), kStddev_rad, prediction);
  require(set.candidates.size() == lights.size(), "a light in a scan is lost");
  for (const core::Bearing& bearing : set.candidates) requireBearing(bearing);
  require(set.view.isPossible(), "a scan's field of view is no part of a turn");
  return !lights.empty();
}

geometry_msgs::TransformStamped drawConnection(ByteReader* bytes) {
  static constexpr const char* kFrames[] = {"sensor", "/sensor", "detector", "/detector", ""};
  geometry_msgs::TransformStamped connection;
  connection.header.frame_id = bytes->pick(kFrames);
  connection.child_frame_id = bytes->pick(kFrames);
  geometry_msgs::Vector3& t = connection.transform.translation;
  geometry_msgs::Quaternion& q = connection.transform.rotation;
  for (double* number : {&t.x, &t.y, &t.z, &q.x, &q.y, &q.z, &q.w}) {
    *number = bytes->flag() ? bytes->anyNumber() : 0.5;
  }
  return connection;
}

bool runPoint(ByteReader* bytes) {
  tf2_msgs::TFMessage connections;
  constexpr int kMostConnections = 4;
  for (int i = bytes->byte() % kMostConnections; i > 0; --i) {
    connections.transforms.push_back(drawConnection(bytes));
  }
  ros_side::SensorPlaces places("sensor");
  places.add(connections);
  std_msgs::Header header;
  header.stamp = ros::Time(bytes->byte(), 0);
  constexpr std::size_t kMostOfName = 8;
  header.frame_id = bytes->flag() ? "detector" : bytes->text(kMostOfName);
  if (const auto refusal = places.refusalOf(header)) {
    require(!refusal->kind.empty() && !refusal->text.empty(), "a refusal says nothing");
    return false;
  }
  Eigen::Vector3d point_m;
  for (double& coordinate : point_m) coordinate = bytes->anyNumber();
  const Eigen::Vector3d in_sensor_m = places.sensorFrom(header.frame_id) * point_m;
  if (core::whyNoPoint(point_m) != nullptr || core::whyNoAzimuth(in_sensor_m) != nullptr) {
    return false;
  }
  requireBearing(core::bearingOfPoint(in_sensor_m, kStddev_rad));
  return true;
}

}  // namespace

bool run(const std::uint8_t* data, std::size_t size) {
  console_bridge::noOutputHandler();  // tf2 complains there, of every input
  ByteReader bytes(data, size);
  return bytes.flag() ? runScan(&bytes) : runPoint(&bytes);
}

}  // namespace bearing_calibration::fuzz
