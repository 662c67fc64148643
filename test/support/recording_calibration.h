#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core::testing {

/// Folder of the real recordings, from the environment variable BEARING_CALIBRATION_DATA.
std::optional<std::string> recordingsFolder();

/// What is known of a recording beforehand.
struct RecordingSetup {
  std::string set;       ///< folder of the recording
  std::string odometry;  ///< file of the odometry in it
  double wheel_separation_m = 0.0;
  WheelNoise wheel_noise;
  double latency_s = 0.0;
  double bearing_stddev_rad = 0.0;
  ErrorPriors errors;             ///< none looked for unless given
  NoisePriors noise;              ///< the same
  double meters_per_tick = 1e-5;  ///< of recorded ticks; else of those that metres are made into
};

/// One landmark of a recording: ticks and bearings as they would arrive.
struct LandmarkRecording {
  std::vector<WheelCounts> ticks;
  std::vector<BearingSet> bearings;
};

LandmarkRecording readLandmark(const RecordingSetup& setup, std::int32_t landmark_id);

/// Ids of the landmarks that have at least `fewest_observations` bearings.
std::vector<std::int32_t> landmarksOf(const RecordingSetup& setup, std::size_t fewest_observations);

CalibratorConfig configFor(const RecordingSetup& setup);

/// True mount of a recording with the standard deviations of that truth.
struct RecordedTruth {
  Pose2 base_from_sensor;
  Eigen::Vector3d stddev = Eigen::Vector3d::Zero();  ///< x [m], y [m], yaw [rad]
};
RecordedTruth readTruth(const std::string& set);

/// An estimate against the truth.
struct MountError {
  double position_m = 0.0;
  double yaw_rad = 0.0;
  double chi_square = 0.0;  ///< 3 degrees of freedom; the truth's own covariance is added
};
MountError errorOf(const MountEstimate& estimate, const RecordedTruth& truth);

}  // namespace bearing_calibration::core::testing
