#include "bearing_calibration/output/result_export.h"

#include <Eigen/Geometry>
#include <array>
#include <boost/algorithm/string/replace.hpp>
#include <cmath>
#include <map>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

struct Form {
  const char* name;
  const char* text;  ///< each {word} stands for its value; ${word} is xacro's
};
constexpr std::array<Form, 6> kForms{{
    {"mount.urdf", R"(<?xml version="1.0"?>
<!-- {summary}
     Copy the joint into your robot's URDF; the link {child} too, unless it is there already. -->
<robot name="bearing_calibration">
  <link name="{parent}"/>
  <link name="{child}"/>
  <joint name="{child}_joint" type="fixed">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="{x} {y} {z}" rpy="{roll} {pitch} {yaw}"/>
  </joint>
</robot>
)"},
    {"mount.urdf.xacro", R"(<?xml version="1.0"?>
<!-- {summary}
     Include this file and call <xacro:bearing_calibration_mount/>, with other values for its
     arguments where they differ. The links are the robot's own. -->
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="bearing_calibration_mount"
               params="parent:={parent} child:={child} z:={z} roll:={roll} pitch:={pitch}">
    <joint name="${child}_joint" type="fixed">
      <parent link="${parent}"/>
      <child link="${child}"/>
      <origin xyz="{x} {y} ${z}" rpy="${roll} ${pitch} {yaw}"/>
    </joint>
  </xacro:macro>
</robot>
)"},
    {"static_transform.launch", R"(<?xml version="1.0"?>
<!-- {summary}
     For a robot without a URDF: a frame may have one parent only. -->
<launch>
  <!-- x y z yaw pitch roll parent child -->
  <node pkg="tf2_ros" type="static_transform_publisher" name="bearing_calibration_mount"
        args="{x} {y} {z} {yaw} {pitch} {roll} {parent} {child}"/>
</launch>
)"},
    {"kalibr_camchain.yaml", R"(# {summary}
# Kalibr's convention, {base} in the place of the IMU: maps points from there to {camera}.
cam0:
  T_cam_imu:
  - [{camera_from_base_0}]
  - [{camera_from_base_1}]
  - [{camera_from_base_2}]
  - [{camera_from_base_3}]
)"},
    {"vins_extrinsics.yaml", R"(%YAML:1.0
---
# {summary}
# Maps points from {camera} to {base}.
body_T_cam0: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [{base_from_camera_0},
          {base_from_camera_1},
          {base_from_camera_2},
          {base_from_camera_3}]
)"},
    {"diff_drive_controller.yaml", R"(# {summary}
# For diff_drive_controller's namespace.
wheel_separation_multiplier: {separation}
left_wheel_radius_multiplier: {left_radius}
right_wheel_radius_multiplier: {right_radius}
)"},
}};

using Values = std::map<std::string, std::string>;

/// A form with each {word} replaced by its value.
std::string filled(const std::string& form, const Values& values) {
  std::string text;
  for (std::size_t i = 0; i < form.size(); ++i) {
    const std::size_t end = form[i] == '{' ? form.find('}', i) : std::string::npos;
    const auto word =
        end == std::string::npos ? values.end() : values.find(form.substr(i + 1, end - i - 1));
    const bool is_xacros = i > 0 && form[i - 1] == '$';
    if (word == values.end() || is_xacros) {
      text += form[i];
    } else {
      text += word->second;
      i = end;
    }
  }
  return text;
}

std::string escapedForXml(std::string text) {
  boost::replace_all(text, "&", "&amp;");
  boost::replace_all(text, "<", "&lt;");
  boost::replace_all(text, "\"", "&quot;");
  return text;
}

/// One sentence for people, without anything that ends a comment in XML or YAML.
std::string summaryOf(const SavedCalibration& calibration) {
  const Eigen::Vector3d stddev = calibration.mount().covariance.diagonal().cwiseSqrt();
  return formatted(
      "%s, %s: x +-%.1f mm, y +-%.1f mm, yaw +-%.2f deg (one standard deviation); z, roll and "
      "pitch are configured, not estimated.",
      nameOf(calibration.result.state), calibration.provenance.written_at.c_str(),
      kMillimetresPerMetre * stddev.x(), kMillimetresPerMetre * stddev.y(),
      degreesFromRadians(stddev.z()));
}

/// To the micrometre and microradian: finer than anything that is built.
std::string fine(double value) {
  constexpr double kMicro = 1e-6;
  return shortestText(std::round(value / kMicro) / (1.0 / kMicro) + 0.0);  // no -0
}

/// The rows of a transform, numbers separated by commas, as NAME_0 to NAME_3.
void addRows(const std::string& name, const Eigen::Isometry3d& transform, Values* values) {
  for (int row = 0; row < 4; ++row) {
    std::string& text = (*values)[name + "_" + std::to_string(row)];
    for (int column = 0; column < 4; ++column) {
      text += (column == 0 ? "" : ", ") + shortestText(transform.matrix()(row, column));
    }
  }
}

/// 1 plus a part of a block of the robot's errors, with what is known of it as a comment.
std::string multiplierOf(const SavedCalibration& calibration, const char* block, std::size_t part) {
  double value = 1.0;
  std::string why = "not estimated";
  for (const BlockReport& report : calibration.blocks()) {
    if (report.name != block || report.status == BlockStatus::kOff) continue;
    const ReportedNumber& number = report.numbers[part];
    value += number.value;
    why = "+- " + shortestText(number.stddev) + ", " + nameOf(report.status);
  }
  return shortestText(value) + (value == std::floor(value) ? ".0" : "") + "  # " + why;
}

Values valuesOf(const SavedCalibration& calibration) {
  const Eigen::Vector3d& mount = calibration.mount().mean;
  const UnestimatedMount& rest = calibration.unestimated;
  const Eigen::Isometry3d base_from_camera =
      Eigen::Translation3d(mount.x(), mount.y(), rest.z_m) *
      Eigen::AngleAxisd(mount.z(), Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(rest.pitch_rad, Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(rest.roll_rad, Eigen::Vector3d::UnitX());
  Values values = {{"summary", summaryOf(calibration)},
                   {"base", calibration.base_frame},
                   {"camera", calibration.sensor_frame},
                   {"parent", escapedForXml(calibration.base_frame)},
                   {"child", escapedForXml(calibration.sensor_frame)},
                   {"x", fine(mount.x())},
                   {"y", fine(mount.y())},
                   {"z", fine(rest.z_m)},
                   {"roll", fine(rest.roll_rad)},
                   {"pitch", fine(rest.pitch_rad)},
                   {"yaw", fine(mount.z())},
                   {"separation", multiplierOf(calibration, WheelSeparation::kName, 0)},
                   {"left_radius", multiplierOf(calibration, WheelScales::kName, 0)},
                   {"right_radius", multiplierOf(calibration, WheelScales::kName, 1)}};
  addRows("camera_from_base", base_from_camera.inverse(), &values);
  addRows("base_from_camera", base_from_camera, &values);
  return values;
}

}  // namespace

std::vector<FileText> formsOf(const SavedCalibration& calibration) {
  std::vector<FileText> files;
  if (!mayBeTrusted(calibration.result.state)) return files;
  const Values values = valuesOf(calibration);
  for (const Form& form : kForms) files.push_back({form.name, filled(form.text, values)});
  return files;
}

}  // namespace bearing_calibration::core
