#include "bearing_calibration_ros/visualisation_markers.h"

#include <geometry_msgs/Point.h>
#include <std_msgs/ColorRGBA.h>

#include <cmath>
#include <vector>

namespace bearing_calibration_ros {
namespace {

using visualization_msgs::Marker;

// Okabe and Ito's colours, which colour-blind readers tell apart.
constexpr float kOpaque = 1.0F;
constexpr float kSheer = 0.35F;
std_msgs::ColorRGBA colour(float red, float green, float blue, float alpha) {
  std_msgs::ColorRGBA colour;
  colour.r = red;
  colour.g = green;
  colour.b = blue;
  colour.a = alpha;
  return colour;
}
std_msgs::ColorRGBA grey(float alpha) { return colour(0.62F, 0.66F, 0.72F, alpha); }
std_msgs::ColorRGBA orange(float alpha) { return colour(0.90F, 0.62F, 0.0F, alpha); }
std_msgs::ColorRGBA vermilion(float alpha) { return colour(0.95F, 0.42F, 0.10F, alpha); }
std_msgs::ColorRGBA blue(float alpha) { return colour(0.34F, 0.71F, 0.91F, alpha); }
std_msgs::ColorRGBA yellow(float alpha) { return colour(0.94F, 0.89F, 0.26F, alpha); }

constexpr double kThin_m = 0.001;   // lines about the sensor, which is seen from near
constexpr double kThick_m = 0.008;  // lines across the room
constexpr double kSensorAxis_m = 0.08;
constexpr double kYawBand_m = 0.2;     // length of the lines that bound the yaw
constexpr double kLight_m = 0.03;      // diameter of the ball: to be seen, not to scale
constexpr double kText_m = 0.05;       // height of a capital letter
constexpr double kTextAside_m = 0.35;  // to the left of the start, where few drive first

geometry_msgs::Point pointAt(const Eigen::Vector2d& position_m, double z_m) {
  geometry_msgs::Point point;
  point.x = position_m.x();
  point.y = position_m.y();
  point.z = z_m;
  return point;
}

/// The stamp stays zero: RViz takes the newest transform, also for those who come late.
Marker marker(const std::string& frame, const std::string& name, int id, int type,
              const std_msgs::ColorRGBA& colour) {
  Marker marker;
  marker.header.frame_id = frame;
  marker.ns = name;
  marker.id = id;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.frame_locked = true;
  marker.color = colour;
  marker.pose.orientation.w = 1.0;
  return marker;
}

void setSize(double x_m, double y_m, double z_m, Marker* marker) {
  marker->scale.x = x_m;
  marker->scale.y = y_m;
  marker->scale.z = z_m;
}

/// RViz complains of lines without points: those are deleted, too.
void finish(bool is_known, std::vector<Marker>* markers, Marker marker) {
  const bool wants_points = marker.type == Marker::LINE_STRIP || marker.type == Marker::LINE_LIST ||
                            marker.type == Marker::TRIANGLE_LIST;
  if (!is_known || (wants_points && marker.points.size() < 2)) marker.action = Marker::DELETE;
  markers->push_back(std::move(marker));
}

void addRobot(const CalibrationNodeConfig& config, std::vector<Marker>* markers) {
  constexpr double kBodyHeight_m = 0.02;
  constexpr double kWheelPart = 0.3;  // its width over its radius
  const double separation_m = config.calibrator.drive.wheel_separation_m;
  const double radius_m = config.calibrator.drive.left_wheel_radius_m;
  Marker body = marker(config.frames.base, "robot", 0, Marker::CYLINDER, grey(kSheer));
  setSize(separation_m, separation_m, kBodyHeight_m, &body);
  finish(true, markers, body);
  for (const int side : {1, -1}) {
    Marker wheel =
        marker(config.frames.base, "robot", side > 0 ? 1 : 2, Marker::CYLINDER, grey(kOpaque));
    wheel.pose.position.y = side * 0.5 * separation_m;
    wheel.pose.orientation.w = wheel.pose.orientation.x = std::sqrt(0.5);  // its axis along y
    setSize(2.0 * radius_m, 2.0 * radius_m, kWheelPart * radius_m, &wheel);
    finish(true, markers, wheel);
  }
  constexpr double kHeadThickness = 3.0;  // of the arrow's shaft
  Marker ahead = marker(config.frames.base, "robot", 3, Marker::ARROW, grey(kOpaque));
  ahead.points = {pointAt({0.0, 0.0}, 0.0), pointAt({0.6 * separation_m, 0.0}, 0.0)};
  setSize(kThick_m, kHeadThickness * kThick_m, kHeadThickness * kThick_m, &ahead);
  finish(true, markers, ahead);
}

/// An ellipse as a closed line (`id`) and as a surface (`id` + 1).
void addEllipse(const std::vector<Eigen::Vector2d>& outline, double z_m, double width_m,
                bool is_known, Marker line, std::vector<Marker>* markers) {
  Marker surface = line;
  surface.id = line.id + 1;
  surface.type = Marker::TRIANGLE_LIST;
  surface.color.a = kSheer;
  setSize(1.0, 1.0, 1.0, &surface);
  line.scale.x = width_m;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    line.points.push_back(pointAt(outline[i], z_m));
    if (i < 2) continue;
    for (const std::size_t corner : {std::size_t{0}, i - 1, i}) {
      surface.points.push_back(pointAt(outline[corner], z_m));
    }
  }
  finish(is_known, markers, line);
  finish(is_known, markers, surface);
}

Eigen::Vector2d awayFrom(const core::Pose2& pose, double direction_rad, double length_m) {
  return pose *
         Eigen::Vector2d(length_m * std::cos(direction_rad), length_m * std::sin(direction_rad));
}

void addSensor(const core::Visualisation& visualisation, const CalibrationNodeConfig& config,
               std::vector<Marker>* markers) {
  const bool is_known = visualisation.found.has_value();
  const auto found = visualisation.found.value_or(core::Visualisation::Found{});
  const double z_m = config.unestimated_mount.z_m;
  const core::Pose2& pose = found.base_from_sensor;
  Marker axes = marker(config.frames.base, "sensor", 0, Marker::LINE_LIST, grey(kOpaque));
  axes.scale.x = 2.0 * kThin_m;
  const std_msgs::ColorRGBA axis_colours[] = {colour(1.0F, 0.1F, 0.1F, kOpaque),
                                              colour(0.1F, 0.9F, 0.1F, kOpaque)};
  for (int axis = 0; axis < 2; ++axis) {
    axes.points.push_back(pointAt(pose.position_m, z_m));
    axes.points.push_back(pointAt(awayFrom(pose, 0.5 * core::kPi * axis, kSensorAxis_m), z_m));
    axes.colors.insert(axes.colors.end(), 2, axis_colours[axis]);
  }
  finish(is_known, markers, axes);
  addEllipse(found.sensor_ellipse_in_base, z_m, kThin_m, is_known,
             marker(config.frames.base, "sensor", 1, Marker::LINE_STRIP, vermilion(kOpaque)),
             markers);
  Marker band = marker(config.frames.base, "sensor", 3, Marker::LINE_LIST, vermilion(kOpaque));
  band.scale.x = kThin_m;
  for (const int side : {1, -1}) {
    band.points.push_back(pointAt(pose.position_m, z_m));
    band.points.push_back(
        pointAt(awayFrom(pose, side * found.sensor_yaw_band_rad, kYawBand_m), z_m));
  }
  finish(is_known && found.sensor_yaw_band_rad < core::kPi, markers, band);
}

/// Each a ball with its ellipse; one that the mount does not rest on is grey.
void addLights(const core::Visualisation& visualisation, const CalibrationNodeConfig& config,
               std::vector<Marker>* markers) {
  constexpr int kMarkersOfLight = 3;
  const auto found = visualisation.found.value_or(core::Visualisation::Found{});
  const std::string& frame = config.output.start_frame;
  const double z_m = config.unestimated_mount.z_m;
  for (int i = 0; i < config.calibrator.max_lights; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool is_known = at < found.lights.size();
    const core::Visualisation::Light light =
        is_known ? found.lights[at] : core::Visualisation::Light{{}, {}, i == 0};
    const std_msgs::ColorRGBA body = light.in_estimate ? yellow(kOpaque) : grey(kOpaque);
    const std_msgs::ColorRGBA around = light.in_estimate ? orange(kOpaque) : grey(kOpaque);
    const int id = kMarkersOfLight * i;
    Marker ball = marker(frame, "light", id, Marker::SPHERE, body);
    ball.pose.position = pointAt(light.in_start, z_m);
    setSize(kLight_m, kLight_m, kLight_m, &ball);
    finish(is_known, markers, ball);
    addEllipse(light.ellipse_in_start, z_m + kLight_m, 0.5 * kThick_m, is_known,
               marker(frame, "light", id + 1, Marker::LINE_STRIP, around), markers);
  }
}

void addRay(const core::Visualisation& visualisation, const CalibrationNodeConfig& config,
            std::vector<Marker>* markers) {
  Marker ray = marker(config.output.start_frame, "ray", 0, Marker::LINE_LIST, yellow(kOpaque));
  ray.scale.x = 0.5 * kThick_m;
  const double z_m = config.unestimated_mount.z_m;
  if (const auto& ends = visualisation.ray_in_start) {
    ray.points = {pointAt(ends->front(), z_m), pointAt(ends->back(), z_m)};
  }
  finish(visualisation.ray_in_start.has_value(), markers, ray);
}

void addPath(const core::Visualisation& visualisation, const CalibrationNodeConfig& config,
             std::vector<Marker>* markers) {
  Marker path = marker(config.output.start_frame, "path", 0, Marker::LINE_STRIP, blue(kOpaque));
  path.scale.x = kThick_m;
  for (const Eigen::Vector2d& point : visualisation.path_in_start) {
    path.points.push_back(pointAt(point, 0.0));
  }
  finish(true, markers, path);
}

void addState(const std::string& state, const CalibrationNodeConfig& config,
              std::vector<Marker>* markers) {
  Marker text =
      marker(config.output.start_frame, "state", 0, Marker::TEXT_VIEW_FACING, grey(kOpaque));
  text.text = state;
  text.scale.z = kText_m;
  text.pose.position = pointAt({0.0, kTextAside_m}, config.unestimated_mount.z_m);
  finish(!state.empty(), markers, text);
}

}  // namespace

visualization_msgs::MarkerArray markersFromVisualisation(const core::Visualisation& visualisation,
                                                         const std::string& state,
                                                         const CalibrationNodeConfig& config) {
  visualization_msgs::MarkerArray array;
  addRobot(config, &array.markers);
  addSensor(visualisation, config, &array.markers);
  addLights(visualisation, config, &array.markers);
  addRay(visualisation, config, &array.markers);
  addPath(visualisation, config, &array.markers);
  addState(state, config, &array.markers);
  return array;
}

}  // namespace bearing_calibration_ros
