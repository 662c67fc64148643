#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "bearing_calibration/output/result_file.h"
#include "result_file_format.h"

namespace bearing_calibration::core {
namespace {

// Everything that is wrong with a file is thrown as std::runtime_error, without the path.

YAML::Node child(const YAML::Node& parent, const std::string& key) {
  const YAML::Node node = parent.IsMap() ? parent[key] : YAML::Node(YAML::NodeType::Undefined);
  if (!node.IsDefined()) throw std::runtime_error("'" + key + "' is missing");
  return node;
}

template <typename Value>
Value read(const YAML::Node& parent, const std::string& key) {
  const YAML::Node node = child(parent, key);
  try {
    return node.as<Value>();
  } catch (const YAML::Exception&) {
    throw std::runtime_error("'" + key + "' has a value of a wrong kind");
  }
}

double readFinite(const YAML::Node& parent, const std::string& key) {
  const double value = read<double>(parent, key);
  if (!std::isfinite(value)) throw std::runtime_error("'" + key + "' is not finite");
  return value;
}

/// Symmetric, no negative eigenvalue, no variance of zero.
Eigen::MatrixXd readCovariance(const YAML::Node& parent, const std::string& key, int size) {
  const auto rows = read<std::vector<std::vector<double>>>(parent, key);
  const auto count = static_cast<std::size_t>(size);
  bool is_square = rows.size() == count;
  for (const std::vector<double>& row : rows) is_square = is_square && row.size() == count;
  if (!is_square) {
    throw std::runtime_error("'" + key + "' does not have " + std::to_string(size) + "x" +
                             std::to_string(size) + " numbers");
  }
  Eigen::MatrixXd matrix(size, size);
  for (int i = 0; i < size; ++i) {
    matrix.row(i) =
        Eigen::Map<const Eigen::RowVectorXd>(rows[static_cast<std::size_t>(i)].data(), size);
  }
  constexpr double kRounding = 1e-9;  // relative; far above that of an update in doubles
  const double rounding = kRounding * matrix.cwiseAbs().maxCoeff();
  const bool is_covariance =
      matrix.allFinite() && matrix.diagonal().minCoeff() > 0.0 &&
      (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= rounding &&
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues().minCoeff() >= -rounding;
  if (!is_covariance) throw std::runtime_error("'" + key + "' is not a covariance");
  return matrix;
}

LastingEstimate readLasting(const YAML::Node& root) {
  const YAML::Node node = child(root, "lasting");
  const YAML::Node mean = child(node, "mean");
  const std::vector<std::string> names = lastingNames();
  LastingEstimate lasting;
  std::vector<int> known;
  for (int i = 0; i < LastingEstimate::kSize; ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    if (i >= LastingEstimate::kMountSize && !mean[name].IsDefined()) continue;
    lasting.mean(i) = readFinite(mean, name);
    known.push_back(i);
  }
  const auto size = static_cast<int>(known.size());
  const Eigen::MatrixXd covariance = readCovariance(node, "covariance", size);
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      lasting.covariance(known[static_cast<std::size_t>(row)],
                         known[static_cast<std::size_t>(column)]) = covariance(row, column);
    }
  }
  return lasting;
}

CalibrationState readState(const YAML::Node& root) {
  const std::string name = read<std::string>(root, "state");
  for (auto value = static_cast<int>(CalibrationState::kWaitingForTicks);
       value <= static_cast<int>(CalibrationState::kPaused); ++value) {
    const auto state = static_cast<CalibrationState>(value);
    if (name == nameOf(state)) return state;
  }
  throw std::runtime_error("'state' is none that is known: " + name);
}

void readMount(const YAML::Node& root, SavedCalibration* calibration) {
  calibration->base_frame = read<std::string>(root, "base_frame");
  calibration->sensor_frame = read<std::string>(root, "camera_frame");
  const YAML::Node mount = child(root, "base_from_camera");
  calibration->base_from_sensor.mean << readFinite(mount, "x"), readFinite(mount, "y"),
      readFinite(mount, "yaw");
  calibration->base_from_sensor.covariance = readCovariance(root, "covariance_x_y_yaw", 3);

  const YAML::Node rest = child(root, "not_estimated");
  UnestimatedMount& unestimated = calibration->unestimated;
  unestimated.z_m = readFinite(rest, "z_m");
  unestimated.z_stddev_m = readFinite(rest, "z_stddev_m");
  unestimated.roll_rad = readFinite(rest, "roll_rad");
  unestimated.roll_stddev_rad = readFinite(rest, "roll_stddev_rad");
  unestimated.pitch_rad = readFinite(rest, "pitch_rad");
  unestimated.pitch_stddev_rad = readFinite(rest, "pitch_stddev_rad");
  const std::vector<std::string> errors = errorsOf(unestimated);
  if (!errors.empty()) throw std::runtime_error(errors.front());
}

void readStates(const YAML::Node& root, SavedCalibration* calibration) {
  const YAML::Node paper = child(root, "paper_state");
  calibration->paper_state.mean << readFinite(paper, "D_m"), readFinite(paper, "theta_rad"),
      readFinite(paper, "phi_rad"), readFinite(paper, "rho_m"), readFinite(paper, "psi_rad");
  calibration->paper_state.phi_psi_determined = read<bool>(paper, "phi_psi_determined");
  calibration->paper_state.covariance = readCovariance(paper, "covariance_D_theta_phi_rho_psi", 5);

  const YAML::Node cartesian = child(root, "cartesian_state");
  calibration->cartesian_state.mean << readFinite(cartesian, "light_x_m"),
      readFinite(cartesian, "light_y_m"), readFinite(cartesian, "sensor_x_m"),
      readFinite(cartesian, "sensor_y_m"), readFinite(cartesian, "sensor_yaw_rad");
  calibration->cartesian_state.covariance = readCovariance(cartesian, "covariance", 5);
}

void readOrigin(const YAML::Node& root, SavedCalibration* calibration) {
  const YAML::Node record = child(root, "record");
  calibration->nis_mean = readFinite(record, "nis_mean");
  calibration->distance_travelled_m = readFinite(record, "distance_travelled_m");
  calibration->rotation_travelled_rad = readFinite(record, "rotation_travelled_rad");
  calibration->bearings_used = read<std::uint32_t>(record, "bearings_used");
  calibration->bearings_gated = read<std::uint32_t>(record, "bearings_gated");
  calibration->ticks_used = read<std::uint32_t>(record, "ticks_used");
  calibration->rejections = read<std::string>(record, "rejections");

  const YAML::Node origin = child(root, "provenance");
  calibration->provenance.program = read<std::string>(origin, "program");
  calibration->provenance.written_at = read<std::string>(origin, "written_at");
  calibration->provenance.source = read<std::string>(origin, "source");
  DriveGeometry& drive = calibration->provenance.drive;
  drive.wheel_separation_m = readFinite(origin, "wheel_separation_m");
  drive.left_wheel_radius_m = readFinite(origin, "left_wheel_radius_m");
  drive.right_wheel_radius_m = readFinite(origin, "right_wheel_radius_m");
  drive.ticks_per_revolution = readFinite(origin, "ticks_per_revolution");
  drive.counter_bits = read<int>(origin, "counter_bits");
  drive.max_wheel_speed_mps = readFinite(origin, "max_wheel_speed_mps");
}

SavedCalibration calibrationFromYaml(const YAML::Node& root) {
  if (!root.IsMap() || !root["format"] || root["format"].as<std::string>("") != kResultFileFormat) {
    throw std::runtime_error("it is not a result file of this package");
  }
  const int version = read<int>(root, "version");
  if (version != kResultFileVersion) {
    throw std::runtime_error("it has version " + std::to_string(version) +
                             ", but this program reads version " +
                             std::to_string(kResultFileVersion));
  }
  SavedCalibration calibration;
  calibration.state = readState(root);
  calibration.advice = read<std::string>(root, "advice");
  calibration.stamp = stampFromNanoseconds(read<std::int64_t>(root, "stamp_ns"));
  readMount(root, &calibration);
  readStates(root, &calibration);
  calibration.lasting = readLasting(root);
  readOrigin(root, &calibration);
  if (!read<bool>(root, "complete")) throw std::runtime_error("it is marked as incomplete");
  return calibration;
}

}  // namespace

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
