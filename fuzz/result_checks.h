#pragma once

#include <string>

#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::fuzz {

/// What holds of every result, whatever went in: numbers are finite, angles are angles, covariances
/// are covariances, CONVERGED needs motion.
/// @throws std::logic_error for what does not hold
void requireMeaning(const core::CalibrationResult& result);

/// Symmetric, and no eigenvalue below zero but for rounding.
void requireCovariance(const Eigen::MatrixXd& matrix, const std::string& name);

/// A file of its own with this text, while it is needed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// What readResultFile() makes of a file of this text.
core::ResultFileContent readBack(const std::string& text);

/// That a written result is read, with the same values.
void requireRoundTrip(const core::SavedCalibration& saved);

}  // namespace bearing_calibration::fuzz
