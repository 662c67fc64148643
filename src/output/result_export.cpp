#include "bearing_calibration/output/result_export.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/output/saving_rule.h"

namespace bearing_calibration::core {
namespace {

std::string escapedForXml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string rounded(double value, int digits) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  text << value;
  return text.str();
}

/// One sentence for people, without anything that ends a comment in XML or YAML.
std::string summaryOf(const SavedCalibration& calibration) {
  const MountEstimate& mount = calibration.base_from_sensor;
  const auto stddev = [&](int i) { return std::sqrt(mount.covariance(i, i)); };
  return std::string(nameOf(calibration.state)) + ", " + calibration.provenance.written_at +
         ": x +-" + rounded(1000.0 * stddev(0), 1) + " mm, y +-" + rounded(1000.0 * stddev(1), 1) +
         " mm, yaw +-" + rounded(degreesFromRadians(stddev(2)), 2) +
         " deg (one standard deviation); z, roll and pitch are configured, not estimated.";
}

Eigen::Isometry3d baseFromCamera(const SavedCalibration& calibration) {
  const Eigen::Vector3d& mount = calibration.base_from_sensor.mean;
  const UnestimatedMount& rest = calibration.unestimated;
  return Eigen::Translation3d(mount.x(), mount.y(), rest.z_m) *
         Eigen::AngleAxisd(mount.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(rest.pitch_rad, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rest.roll_rad, Eigen::Vector3d::UnitX());
}

/// The numbers of one row, separated by commas.
std::string rowText(const Eigen::Matrix4d& matrix, int row) {
  std::string text;
  for (int column = 0; column < matrix.cols(); ++column) {
    text += (column == 0 ? "" : ", ") + shortestText(matrix(row, column));
  }
  return text;
}

using Words = std::map<std::string, std::string>;

/// A form with each {word} replaced by its value; ${word} is left to xacro.
std::string filled(const std::string& form, const Words& words) {
  std::string text;
  for (std::size_t i = 0; i < form.size(); ++i) {
    const std::size_t end = form[i] == '{' ? form.find('}', i) : std::string::npos;
    const auto word =
        end == std::string::npos ? words.end() : words.find(form.substr(i + 1, end - i - 1));
    const bool is_xacros = i > 0 && form[i - 1] == '$';
    if (word == words.end() || is_xacros) {
      text += form[i];
    } else {
      text += word->second;
      i = end;
    }
  }
  return text;
}

/// To the micrometre and microradian: finer than anything that is built.
std::string fine(double value) {
  constexpr double kMicro = 1e-6;
  return shortestText(std::round(value / kMicro) / (1.0 / kMicro));
}

Words xmlWordsOf(const SavedCalibration& calibration) {
  const Eigen::Vector3d& mount = calibration.base_from_sensor.mean;
  const UnestimatedMount& rest = calibration.unestimated;
  return {{"summary", summaryOf(calibration)},
          {"parent", escapedForXml(calibration.base_frame)},
          {"child", escapedForXml(calibration.sensor_frame)},
          {"x", fine(mount.x())},
          {"y", fine(mount.y())},
          {"z", fine(rest.z_m)},
          {"roll", fine(rest.roll_rad)},
          {"pitch", fine(rest.pitch_rad)},
          {"yaw", fine(mount.z())}};
}

struct Form {
  const char* name;
  std::string (*from)(const SavedCalibration&);
};
constexpr std::array<Form, 6> kForms{{
    {"mount.urdf", urdfFrom},
    {"mount.urdf.xacro", xacroFrom},
    {"static_transform.launch", launchFrom},
    {"kalibr_camchain.yaml", kalibrFrom},
    {"vins_extrinsics.yaml", vinsFrom},
    {"diff_drive_controller.yaml", diffDriveFrom},
}};

}  // namespace

std::string urdfFrom(const SavedCalibration& calibration) {
  return filled(R"(<?xml version="1.0"?>
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
)",
                xmlWordsOf(calibration));
}

std::string xacroFrom(const SavedCalibration& calibration) {
  return filled(R"(<?xml version="1.0"?>
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
)",
                xmlWordsOf(calibration));
}

std::string launchFrom(const SavedCalibration& calibration) {
  return filled(R"(<?xml version="1.0"?>
<!-- {summary}
     For a robot without a URDF: a frame may have one parent only. -->
<launch>
  <!-- x y z yaw pitch roll parent child -->
  <node pkg="tf2_ros" type="static_transform_publisher" name="bearing_calibration_mount"
        args="{x} {y} {z} {yaw} {pitch} {roll} {parent} {child}"/>
</launch>
)",
                xmlWordsOf(calibration));
}

std::string kalibrFrom(const SavedCalibration& calibration) {
  const Eigen::Matrix4d camera_from_base = baseFromCamera(calibration).inverse().matrix();
  std::string text = "# " + summaryOf(calibration) + "\n# Kalibr's convention, " +
                     calibration.base_frame +
                     " in the place of the IMU: maps points from there to " +
                     calibration.sensor_frame + ".\ncam0:\n  T_cam_imu:\n";
  for (int row = 0; row < 4; ++row) text += "  - [" + rowText(camera_from_base, row) + "]\n";
  return text;
}

std::string vinsFrom(const SavedCalibration& calibration) {
  const Eigen::Matrix4d base_from_camera = baseFromCamera(calibration).matrix();
  std::string data;
  for (int row = 0; row < 4; ++row) {
    data += (row == 0 ? "" : ",\n          ") + rowText(base_from_camera, row);
  }
  return "%YAML:1.0\n---\n# " + summaryOf(calibration) + "\n# Maps points from " +
         calibration.sensor_frame + " to " + calibration.base_frame +
         ".\nbody_T_cam0: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [" + data +
         "]\n";
}

namespace {

/// A parameter of diff_drive_controller: 1 plus a part of a block of the robot's errors.
struct Multiplier {
  const char* name;
  const char* block;
  std::size_t part;
};
constexpr std::array<Multiplier, 3> kMultipliers{{
    {"wheel_separation_multiplier", WheelSeparation::kName, 0},
    {"left_wheel_radius_multiplier", WheelScales::kName, 0},
    {"right_wheel_radius_multiplier", WheelScales::kName, 1},
}};

}  // namespace

std::string diffDriveFrom(const SavedCalibration& calibration) {
  std::string text = "# " + summaryOf(calibration) + "\n# For diff_drive_controller's namespace.\n";
  for (const Multiplier& multiplier : kMultipliers) {
    double value = 1.0;
    std::string why = "not estimated";
    for (const BlockReport& report : calibration.robot_errors) {
      if (report.name != multiplier.block || report.status == BlockStatus::kOff) continue;
      const ReportedNumber& number = report.numbers[multiplier.part];
      value += number.value;
      why = "+- " + shortestText(number.stddev) + ", " + nameOf(report.status);
    }
    text += std::string(multiplier.name) + ": " + shortestText(value);
    if (value == std::floor(value)) text += ".0";
    text += "  # " + why + "\n";
  }
  return text;
}

std::vector<FileText> formsOf(const SavedCalibration& calibration) {
  std::vector<FileText> files;
  if (!mayBeTrusted(calibration.state)) return files;
  for (const Form& form : kForms) files.push_back({form.name, form.from(calibration)});
  return files;
}

}  // namespace bearing_calibration::core
