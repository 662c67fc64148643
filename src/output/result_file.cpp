#include "bearing_calibration/output/result_file.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "result_file_format.h"

namespace bearing_calibration::core {
namespace {

void emit(YAML::Emitter& out, const char* key, double value) {
  out << YAML::Key << key << YAML::Value << shortestText(value);
}

void emit(YAML::Emitter& out, const char* key, const std::string& text) {
  out << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << text;
}

/// One line for each row.
void emit(YAML::Emitter& out, const char* key, const Eigen::MatrixXd& matrix) {
  out << YAML::Key << key << YAML::Value << YAML::BeginSeq;
  for (int row = 0; row < matrix.rows(); ++row) {
    out << YAML::Flow << YAML::BeginSeq;
    for (int column = 0; column < matrix.cols(); ++column) out << shortestText(matrix(row, column));
    out << YAML::EndSeq;
  }
  out << YAML::EndSeq;
}

void beginGroup(YAML::Emitter& out, const char* key) {
  out << YAML::Key << key << YAML::Value << YAML::BeginMap;
}

void emitXYYaw(YAML::Emitter& out, const char* key, const Eigen::Vector3d& x_y_yaw) {
  out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginMap;
  emit(out, "x", x_y_yaw.x());
  emit(out, "y", x_y_yaw.y());
  emit(out, "yaw", x_y_yaw.z());
  out << YAML::EndMap;
}

void emitMount(YAML::Emitter& out, const SavedCalibration& calibration) {
  const MountEstimate& mount = calibration.base_from_sensor;
  emit(out, "base_frame", calibration.base_frame);
  emit(out, "camera_frame", calibration.sensor_frame);
  emitXYYaw(out, "base_from_camera", mount.mean);
  emitXYYaw(out, "stddev", mount.covariance.diagonal().cwiseSqrt());  // for people
  emit(out, "covariance_x_y_yaw", mount.covariance);

  beginGroup(out, "not_estimated");
  emit(out, "z_m", calibration.unestimated.z_m);
  emit(out, "z_stddev_m", calibration.unestimated.z_stddev_m);
  emit(out, "roll_rad", calibration.unestimated.roll_rad);
  emit(out, "roll_stddev_rad", calibration.unestimated.roll_stddev_rad);
  emit(out, "pitch_rad", calibration.unestimated.pitch_rad);
  emit(out, "pitch_stddev_rad", calibration.unestimated.pitch_stddev_rad);
  out << YAML::EndMap;
}

void emitStates(YAML::Emitter& out, const SavedCalibration& calibration) {
  const PaperEstimate& paper = calibration.paper_state;
  beginGroup(out, "paper_state");
  emit(out, "D_m", paper.mean(PaperIndex::kDistance));
  emit(out, "theta_rad", paper.mean(PaperIndex::kTheta));
  emit(out, "phi_rad", paper.mean(PaperIndex::kPhi));
  emit(out, "rho_m", paper.mean(PaperIndex::kRho));
  emit(out, "psi_rad", paper.mean(PaperIndex::kPsi));
  out << YAML::Key << "phi_psi_determined" << YAML::Value << paper.phi_psi_determined;
  emit(out, "covariance_D_theta_phi_rho_psi", paper.covariance);
  out << YAML::EndMap;

  const CartesianEstimate& cartesian = calibration.cartesian_state;
  beginGroup(out, "cartesian_state");
  emit(out, "light_x_m", cartesian.mean(CartesianIndex::kLightX));
  emit(out, "light_y_m", cartesian.mean(CartesianIndex::kLightY));
  emit(out, "sensor_x_m", cartesian.mean(CartesianIndex::kSensorX));
  emit(out, "sensor_y_m", cartesian.mean(CartesianIndex::kSensorY));
  emit(out, "sensor_yaw_rad", cartesian.mean(CartesianIndex::kSensorYaw));
  emit(out, "covariance", cartesian.covariance);
  out << YAML::EndMap;
}

/// What is known of mount and lasting errors together, without what is not.
void emitLasting(YAML::Emitter& out, const StateEstimate& lasting) {
  const std::vector<std::string> names = lastingNames();
  std::vector<int> known;
  for (int i = 0; i < lasting.layout.size(); ++i) {
    if (lasting.covariance(i, i) > 0.0) known.push_back(i);
  }
  const auto size = static_cast<int>(known.size());
  Eigen::MatrixXd covariance(size, size);
  beginGroup(out, "lasting");
  beginGroup(out, "mean");
  for (int row = 0; row < size; ++row) {
    const int place = known[static_cast<std::size_t>(row)];
    emit(out, names[static_cast<std::size_t>(place)].c_str(), lasting.mean(place));
    for (int column = 0; column < size; ++column) {
      covariance(row, column) = lasting.covariance(place, known[static_cast<std::size_t>(column)]);
    }
  }
  out << YAML::EndMap;
  emit(out, "covariance", covariance);
  out << YAML::EndMap;
}

void emitBlocks(YAML::Emitter& out, const std::vector<BlockReport>& reports) {
  out << YAML::Key << "blocks" << YAML::Value;
  if (reports.empty()) out << YAML::Flow;
  out << YAML::BeginSeq;
  for (const BlockReport& report : reports) {
    out << YAML::BeginMap;
    emit(out, "name", report.name);
    emit(out, "status", std::string(nameOf(report.status)));
    beginGroup(out, "value");
    for (const ReportedNumber& number : report.numbers) {
      emit(out, labelOf(number.quantity).c_str(), number.value);
    }
    out << YAML::EndMap;
    beginGroup(out, "stddev");
    for (const ReportedNumber& number : report.numbers) {
      emit(out, labelOf(number.quantity).c_str(), number.stddev);
    }
    out << YAML::EndMap;
    if (!report.note.empty()) emit(out, "note", report.note);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

void emitLights(YAML::Emitter& out, const std::vector<LightSummary>& lights) {
  out << YAML::Key << "lights" << YAML::Value;
  if (lights.empty()) out << YAML::Flow;
  out << YAML::BeginSeq;
  for (const LightSummary& light : lights) {
    out << YAML::BeginMap;
    if (light.light_id != kUnknownLight) out << YAML::Key << "id" << YAML::Value << light.light_id;
    if (light.cartesian_state) {
      const Eigen::Vector2d place = light.cartesian_state->lightInBase();
      const Eigen::Matrix2d covariance = light.cartesian_state->covariance.topLeftCorner<2, 2>();
      emit(out, "x_m", place.x());
      emit(out, "y_m", place.y());
      emit(out, "covariance_x_y", covariance);
    }
    out << YAML::Key << "in_estimate" << YAML::Value << light.in_estimate;
    out << YAML::Key << "bearings_used" << YAML::Value << light.bearings_used;
    if (!light.note.empty()) emit(out, "note", light.note);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

/// Values that are YAML already: quoted strings, lists, plain scalars.
void emitTexts(YAML::Emitter& out, const char* key,
               const std::map<std::string, std::string>& texts) {
  beginGroup(out, key);
  for (const auto& name_and_text : texts) {
    out << YAML::Key << name_and_text.first << YAML::Value;
    const YAML::Node value = YAML::Load(name_and_text.second);
    const bool is_quoted = value.IsScalar() && value.Tag() == "!";
    if (is_quoted) {
      out << YAML::DoubleQuoted << value.Scalar();
    } else {
      out << YAML::Flow << value;
    }
  }
  out << YAML::EndMap;
}

void emitQuality(YAML::Emitter& out, const SavedCalibration& calibration) {
  out << YAML::Key << "quality" << YAML::Value;
  if (calibration.quality.empty()) out << YAML::Flow;
  out << YAML::BeginSeq;
  for (const std::string& sentence : calibration.quality) out << YAML::DoubleQuoted << sentence;
  out << YAML::EndSeq;
}

void emitOrigin(YAML::Emitter& out, const SavedCalibration& calibration) {
  beginGroup(out, "record");
  emit(out, "nis_mean", calibration.nis_mean);
  emit(out, "distance_travelled_m", calibration.distance_travelled_m);
  emit(out, "rotation_travelled_rad", calibration.rotation_travelled_rad);
  out << YAML::Key << "bearings_used" << YAML::Value << calibration.bearings_used;
  out << YAML::Key << "bearings_gated" << YAML::Value << calibration.bearings_gated;
  out << YAML::Key << "ticks_used" << YAML::Value << calibration.ticks_used;
  emit(out, "rejections", calibration.rejections);
  out << YAML::EndMap;

  const DriveGeometry& drive = calibration.provenance.drive;
  beginGroup(out, "provenance");
  emit(out, "program", calibration.provenance.program);
  emit(out, "written_at", calibration.provenance.written_at);
  emit(out, "source", calibration.provenance.source);
  emit(out, "wheel_separation_m", drive.wheel_separation_m);
  emit(out, "left_wheel_radius_m", drive.left_wheel_radius_m);
  emit(out, "right_wheel_radius_m", drive.right_wheel_radius_m);
  emit(out, "ticks_per_revolution", drive.ticks_per_revolution);
  out << YAML::Key << "counter_bits" << YAML::Value << drive.counter_bits;
  emit(out, "max_wheel_speed_mps", drive.max_wheel_speed_mps);
  out << YAML::EndMap;
  emitTexts(out, "versions", calibration.provenance.versions);
  emitTexts(out, "parameters", calibration.provenance.parameters);
}

}  // namespace

std::string shortestText(double value) {
  constexpr int kAlwaysEnoughDigits = 17;
  constexpr std::size_t kLongestText = 32;  // sign, 17 digits, point, exponent
  char text[kLongestText];
  for (int digits = 1; digits <= kAlwaysEnoughDigits; ++digits) {
    std::snprintf(text, sizeof(text), "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  std::string shortest = text;
  const std::size_t exponent = shortest.find('e');
  if (exponent != std::string::npos && shortest.find('.') == std::string::npos) {
    shortest.insert(exponent, ".0");  // YAML 1.1 takes 1e-6 for a string
  }
  return shortest;
}

std::string resultText(const SavedCalibration& calibration) {
  YAML::Emitter out;
  out << YAML::Comment(
      "The sensor's pose in the base frame (x forward, y left, yaw counter-clockwise): it maps\n"
      "points from the sensor's frame to the base's. Lengths in m, angles in rad.");
  out << YAML::BeginMap;
  emit(out, "format", std::string(kResultFileFormat));
  out << YAML::Key << "version" << YAML::Value << kResultFileVersion;
  emit(out, "state", std::string(nameOf(calibration.state)));
  emit(out, "advice", calibration.advice);
  out << YAML::Key << "stamp_ns" << YAML::Value << calibration.stamp.time_since_epoch().count();
  emitMount(out, calibration);
  emitQuality(out, calibration);
  emitStates(out, calibration);
  emitLasting(out, calibration.lasting);
  emitBlocks(out, calibration.robot_errors);
  emitLights(out, calibration.lights);
  emitOrigin(out, calibration);
  out << YAML::Key << "complete" << YAML::Value << true;  // last: a file cut short lacks it
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace bearing_calibration::core
