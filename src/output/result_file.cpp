#include "bearing_calibration/output/result_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "yaml_walk.h"

namespace bearing_calibration::core {
namespace {

constexpr char kFormat[] = "bearing_calibration result";
constexpr int kVersion = 3;  // grows when an older program would misread

template <class Walk, class Vector>
void walkNumbers(Walk& walk, const std::vector<std::string>& keys, Vector& vector) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    walk(keys[i], vector(static_cast<Eigen::Index>(i)));
  }
}

template <class Walk, class Vector>
void walkXYYaw(Walk& walk, const std::string& key, Vector& x_y_yaw) {
  const auto numbers = [&](auto& in) { walkNumbers(in, {"x", "y", "yaw"}, x_y_yaw); };
  walk.group(key, numbers, true);
}

template <class Walk, class Matrix>
void walkCovariance(Walk& walk, const std::string& key, Matrix& matrix) {
  const auto entry = [&](int row, int column) -> auto& { return matrix(row, column); };
  walk.covariance(key, static_cast<int>(matrix.rows()), entry);
}

/// Whether there is a mean of a lasting number: the mount's always are.
bool has(const YamlWriter&, const StateEstimate& lasting, const std::string& /*key*/, int place) {
  return (lasting.covariance(place, place) > 0.0);
}
bool has(const YamlReader& mean, const StateEstimate&, const std::string& key, int place) {
  return place < kMountSize || mean.has(key);
}

/// What is known of mount and lasting errors together, without what is not.
template <class Walk, class Lasting>
void walkLasting(Walk& walk, Lasting& lasting) {
  const std::vector<std::string> names = lastingNames();
  std::vector<int> known;
  walk.group("mean", [&](auto& mean) {
    for (int i = 0; i < lasting.layout.size(); ++i) {
      const std::string& name = names[static_cast<std::size_t>(i)];
      if (!has(mean, lasting, name, i)) continue;
      mean(name, lasting.mean(i));
      known.push_back(i);
    }
  });
  const auto entry = [&](int row, int column) -> auto& {
    const auto place = [&](int i) { return known[static_cast<std::size_t>(i)]; };
    return lasting.covariance(place(row), place(column));
  };
  walk.covariance("covariance", static_cast<int>(known.size()), entry);
}

void writeBlock(YamlWriter& write, const BlockReport& report) {
  write.out << YAML::BeginMap;
  write("name", report.name);
  write("status", nameOf(report.status));
  write.group("value", [&](auto&) {
    for (const auto& number : report.numbers) write(labelOf(number.quantity), number.value);
  });
  write.group("stddev", [&](auto&) {
    for (const auto& number : report.numbers) write(labelOf(number.quantity), number.stddev);
  });
  if (!report.note.empty()) write("note", report.note);
  write.out << YAML::EndMap;
}

void writeLight(YamlWriter& write, const LightSummary& light) {
  write.out << YAML::BeginMap;
  if (light.light_id != kUnknownLight) write("id", light.light_id);
  if (light.cartesian_state) {
    const Eigen::Matrix2d covariance = light.cartesian_state->covariance.topLeftCorner<2, 2>();
    walkNumbers(write, {"x_m", "y_m"}, light.cartesian_state->mean);
    walkCovariance(write, "covariance_x_y", covariance);
  }
  write("in_estimate", light.in_estimate);
  write("bearings_used", light.bearings_used);
  if (!light.note.empty()) write("note", light.note);
  write.out << YAML::EndMap;
}

/// Values that are YAML already: quoted strings, lists, plain scalars.
void writeTexts(YamlWriter& write, const std::string& key,
                const std::map<std::string, std::string>& texts) {
  write.group(key, [&](auto&) {
    for (const auto& [name, text] : texts) {
      const YAML::Node value = YAML::Load(text);
      if (value.IsScalar() && value.Tag() == "!") {
        write(name, value.Scalar());
      } else {
        write.begin(name) << YAML::Flow << value;
      }
    }
  });
}

template <class Walk, class Calibration>
void walkEstimates(Walk& walk, Calibration& saved) {
  auto& mount = *saved.result.base_from_sensor;
  auto& paper = *saved.result.paper_state;
  auto& cartesian = *saved.result.cartesian_state;
  walkXYYaw(walk, "base_from_camera", mount.mean);
  walk.forPeople([&](auto& write) {
    const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
    walkXYYaw(write, "stddev", stddev);
  });
  walkCovariance(walk, "covariance_x_y_yaw", mount.covariance);
  walk.group("not_estimated", [&](auto& rest) {
    rest("z_m", saved.unestimated.z_m);
    rest("z_stddev_m", saved.unestimated.z_stddev_m);
    rest("roll_rad", saved.unestimated.roll_rad);
    rest("roll_stddev_rad", saved.unestimated.roll_stddev_rad);
    rest("pitch_rad", saved.unestimated.pitch_rad);
    rest("pitch_stddev_rad", saved.unestimated.pitch_stddev_rad);
  });
  walk.forPeople([&](auto& write) { write("quality", qualityInWords(saved.result)); });
  walk.group("paper_state", [&](auto& in) {
    walkNumbers(in, {"D_m", "theta_rad", "phi_rad", "rho_m", "psi_rad"}, paper.mean);
    in("phi_psi_determined", paper.phi_psi_determined);
    walkCovariance(in, "covariance_D_theta_phi_rho_psi", paper.covariance);
  });
  walk.group("cartesian_state", [&](auto& in) {
    walkNumbers(in, {"light_x_m", "light_y_m", "sensor_x_m", "sensor_y_m", "sensor_yaw_rad"},
                cartesian.mean);
    walkCovariance(in, "covariance", cartesian.covariance);
  });
  walk.group("lasting", [&](auto& lasting) { walkLasting(lasting, saved.lasting); });
}

template <class Walk, class Calibration>
void walkOrigin(Walk& walk, Calibration& saved) {
  walk.group("record", [&](auto& record) {
    record("nis_mean", saved.result.nis_mean);
    record("distance_travelled_m", saved.result.distance_travelled_m);
    record("rotation_travelled_rad", saved.result.rotation_travelled_rad);
    record("bearings_used", saved.result.bearings_used);
    record("bearings_gated", saved.result.bearings_gated);
    record("ticks_used", saved.result.ticks_used);
    record("rejections", saved.rejections);
  });
  walk.group("provenance", [&](auto& origin) {
    auto& drive = saved.provenance.drive;
    origin("program", saved.provenance.program);
    origin("written_at", saved.provenance.written_at);
    origin("source", saved.provenance.source);
    origin("wheel_separation_m", drive.wheel_separation_m);
    origin("left_wheel_radius_m", drive.left_wheel_radius_m);
    origin("right_wheel_radius_m", drive.right_wheel_radius_m);
    origin("ticks_per_revolution", drive.ticks_per_revolution);
    origin("counter_bits", drive.counter_bits);
    origin("max_wheel_speed_mps", drive.max_wheel_speed_mps);
  });
}

template <class Walk, class Calibration>
void walk(Walk& walk, Calibration& saved) {
  walk("state", saved.result.state);
  walk("advice", saved.result.advice);
  walk("stamp_ns", saved.result.stamp);
  walk("base_frame", saved.base_frame);
  walk("camera_frame", saved.sensor_frame);
  walkEstimates(walk, saved);
  walk.forPeople([&](auto& write) {
    write.list("blocks", saved.blocks(), [&](const auto& block) { writeBlock(write, block); });
    write.list("lights", saved.result.lights, [&](const auto& light) { writeLight(write, light); });
  });
  walkOrigin(walk, saved);
  walk.forPeople([&](auto& write) {
    writeTexts(write, "versions", saved.provenance.versions);
    writeTexts(write, "parameters", saved.provenance.parameters);
  });
}

SavedCalibration calibrationFromYaml(const YAML::Node& root) {
  if (!root.IsMap() || !root["format"] || root["format"].as<std::string>("") != kFormat) {
    throw std::runtime_error("it is not a result file of this package");
  }
  const YamlReader read(root);
  int version = 0;
  read("version", version);
  if (version != kVersion) {
    throw std::runtime_error(
        formatted("it has version %d, but this program reads version %d", version, kVersion));
  }
  SavedCalibration saved;
  saved.result.base_from_sensor.emplace();
  saved.result.paper_state.emplace();
  saved.result.cartesian_state.emplace();
  walk(read, saved);
  const std::vector<std::string> errors = errorsOf(saved.unestimated);
  if (!errors.empty()) throw std::runtime_error(errors.front());
  bool complete = false;
  read("complete", complete);
  if (!complete) throw std::runtime_error("it is marked as incomplete");
  return saved;
}

}  // namespace

std::vector<BlockReport> SavedCalibration::blocks() const {
  return reportErrors(result, std::max(unestimated.roll_stddev_rad, unestimated.pitch_stddev_rad));
}

std::string shortestText(double value) {
  constexpr int kAlwaysEnoughDigits = 17;
  constexpr double kLargestWhole = 1e15;  // up to which "%.0f" has all digits of a whole number
  if (value == std::trunc(value) && std::abs(value) < kLargestWhole) {
    return formatted("%.0f", value);  // not 1e+02: YAML takes that for another kind of number
  }
  std::string text;
  for (int digits = 1; digits <= kAlwaysEnoughDigits; ++digits) {
    text = formatted("%.*g", digits, value);
    if (std::strtod(text.c_str(), nullptr) == value) break;
  }
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");  // YAML 1.1 takes 1e-6 for a string
  }
  return text;
}

std::string resultText(const SavedCalibration& calibration) {
  YamlWriter write;
  write.out << YAML::Comment(
      "The sensor's pose in the base frame (x forward, y left, yaw counter-clockwise): it maps\n"
      "points from the sensor's frame to the base's. Lengths in m, angles in rad.");
  write.out << YAML::BeginMap;
  write("format", kFormat);
  write("version", kVersion);
  walk(write, calibration);
  write("complete", true);  // last: a file cut short lacks it
  write.out << YAML::EndMap;
  return std::string(write.out.c_str()) + "\n";
}

ResultFileContent readResultFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf()))
    return {std::nullopt, path + " cannot be read, or is empty"};
  try {
    return {calibrationFromYaml(YAML::Load(text.str())), ""};
  } catch (const std::exception& error) {  // of YAML too
    return {std::nullopt, path + " is refused: " + error.what()};
  }
}

}  // namespace bearing_calibration::core
