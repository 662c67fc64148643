#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

/// Where a result comes from, and what it rests on.
struct Provenance {
  std::string program;     ///< what wrote it
  std::string written_at;  ///< wall time, for people
  std::string source;      ///< a bag, or what else the measurements came from
  DriveGeometry drive;     ///< the wheels that it was measured with: the result's metric reference
  std::map<std::string, std::string> versions;    ///< of the package and of what it stands on
  std::map<std::string, std::string> parameters;  ///< all of them by name, as YAML
};

/// A calibration as it stands in a file.
struct SavedCalibration {
  CalibrationResult result;  ///< with an estimate; what it says for people alone is not read
  std::string base_frame;
  std::string sensor_frame;
  /// What another start goes on from (lastingPart()).
  StateEstimate lasting = lastingPart(MountEstimate());
  UnestimatedMount unestimated;
  std::string rejections;  ///< what was refused and how often, for people
  Provenance provenance;

  const MountEstimate& mount() const { return *result.base_from_sensor; }
  /// Of the robot's errors and of the noise.
  std::vector<BlockReport> blocks() const;
};

/// The shortest decimal form that reads back to the same double.
std::string shortestText(double value);

/// The content of result.yaml. Numbers are written in the shortest form that reads back to the same
/// value.
std::string resultText(const SavedCalibration& calibration);

/// A file's content, or why it was refused.
struct ResultFileContent {
  std::optional<SavedCalibration> calibration;
  std::string error;  ///< a sentence with the path; empty when there is a calibration
};

/// Reads a file of resultText(), but for versions and parameters, which are for people. A
/// file that is missing, cut short, not of this package or version, or holds values that cannot be
/// (not finite, a covariance that is none) is refused.
ResultFileContent readResultFile(const std::string& path);

}  // namespace bearing_calibration::core
