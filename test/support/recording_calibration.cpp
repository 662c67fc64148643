#include "support/recording_calibration.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Cholesky>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tools/owner/recording_csv.h"
#include "tools/study/default_calibration.h"

namespace bearing_calibration::core::testing {
namespace {

constexpr double kWheelRadius_m = 0.1;
constexpr double kStart_s = 1000.0;  // stamp of t_s = 0; a stamp of zero is none

std::ifstream open(const std::string& set, const std::string& file) {
  const std::string path = *recordingsFolder() + "/" + set + "/" + file;
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error("cannot open " + path);
  return stream;
}

}  // namespace

std::optional<std::string> recordingsFolder() {
  const char* folder = std::getenv("BEARING_CALIBRATION_DATA");
  if (folder == nullptr) return std::nullopt;
  return std::string(folder);
}

LandmarkRecording readLandmark(const RecordingSetup& setup, std::int32_t landmark_id) {
  const RecordingUnits units{setup.meters_per_tick, kStart_s};
  LandmarkRecording recording;
  std::ifstream odometry = open(setup.set, setup.odometry);
  for (const CounterRow& row : readCounters(odometry, setup.odometry, units)) {
    recording.ticks.push_back({row.stamp, row.left_ticks, row.right_ticks});
  }
  std::ifstream bearings = open(setup.set, "bearings.csv");
  for (const ObservationRow& row : readObservations(bearings, "bearings.csv", landmark_id, units)) {
    Bearing bearing;
    bearing.azimuth_rad = row.bearing_rad;
    bearing.azimuth_variance_rad2 = setup.bearing_stddev_rad * setup.bearing_stddev_rad;
    recording.bearings.push_back({row.stamp, {bearing}});
  }
  return recording;
}

std::vector<std::int32_t> landmarksOf(const RecordingSetup& setup,
                                      std::size_t fewest_observations) {
  std::ifstream stream = open(setup.set, "bearings.csv");
  std::string line;
  std::getline(stream, line);  // t_s,landmark_id,...
  std::map<std::int32_t, std::size_t> observations;
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::string time;
    std::string id;
    std::getline(cells, time, ',');
    std::getline(cells, id, ',');
    ++observations[std::stoi(id)];
  }
  std::vector<std::int32_t> landmarks;
  for (const auto& [id, count] : observations) {
    if (count >= fewest_observations) landmarks.push_back(id);
  }
  return landmarks;
}

CalibratorConfig configFor(const RecordingSetup& setup) {
  DriveGeometry drive;
  drive.wheel_separation_m = setup.wheel_separation_m;
  drive.left_wheel_radius_m = kWheelRadius_m;
  drive.right_wheel_radius_m = kWheelRadius_m;
  drive.ticks_per_revolution = 2.0 * kPi * kWheelRadius_m / setup.meters_per_tick;
  drive.counter_bits = 64;
  drive.max_wheel_speed_mps = 3.0;
  CalibratorConfig config = defaultCalibration(drive, setup.wheel_noise);
  config.bearings.latency_s = setup.latency_s;
  config.bearings.max_future_s = 1.0;
  config.initializer.batch.errors = setup.errors;
  config.initializer.noise = setup.noise;
  return config;
}

RecordedTruth readTruth(const std::string& set) {
  const YAML::Node truth = YAML::LoadFile(*recordingsFolder() + "/" + set + "/truth.json");
  RecordedTruth result;
  result.base_from_sensor = {{truth["x_m"].as<double>(), truth["y_m"].as<double>()},
                             truth["yaw_rad"].as<double>()};
  const YAML::Node sigma = truth["sigma"];
  result.stddev << sigma["x_m"].as<double>(), sigma["y_m"].as<double>(),
      sigma["yaw_rad"].as<double>();
  return result;
}

MountError errorOf(const MountEstimate& estimate, const RecordedTruth& truth) {
  Eigen::Vector3d error;
  error << estimate.mean.head<2>() - truth.base_from_sensor.position_m,
      wrapAngle(estimate.mean.z() - truth.base_from_sensor.yaw_rad);
  const Eigen::Matrix3d truth_covariance = truth.stddev.array().square().matrix().asDiagonal();
  return {error.head<2>().norm(), std::abs(error.z()),
          error.dot((estimate.covariance + truth_covariance).ldlt().solve(error))};
}

}  // namespace bearing_calibration::core::testing
