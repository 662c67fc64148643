#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/output/sensor_check.h"
#include "bearing_calibration/solve/observability.h"
#include "bearing_calibration/track/association_outcome.h"

namespace bearing_calibration::core {

/// What became of an image in the light of the whole record.
enum class Verdict : std::uint8_t {
  kNothingSeen,
  kUsed,      ///< its bearing is part of the estimate
  kLeftOut,   ///< the fit of the whole record found it to be an outlier
  kThinned,   ///< a repetition while the robot stood, or one of too many: not looked at
  kUnjudged,  ///< there is no estimate to judge it by
};

/// "used" and so on.
const char* nameOf(Verdict verdict);

/// One image of a record with what the whole record says of it. NaN where there is no such value.
struct ReviewedImage {
  AssociationOutcome outcome;
  Verdict verdict = Verdict::kNothingSeen;
  double distance_m = 0.0;    ///< travelled since the first image
  Pose2 first_from_base;      ///< the base's pose in its frame at the first image, smoothed
  double residual_rad = 0.0;  ///< measured azimuth minus that of the final estimate
  double nis = 0.0;           ///< of kUsed: given the bearings before it, chi-square(1)
};

/// A whole record, once it has ended.
struct Review {
  bool settled = false;  ///< the fit of the whole record, by which its images are judged
  MotionSummary motion;
  double correlation = 0.0;  ///< of neighbouring bearings' noise
  int slips = 0;             ///< motions that were given up
  SensorCheck sensor;
  std::vector<ReviewedImage> images;
};

/// Keeps what a calibration looked at, and judges every image of it at the end. It estimates
/// nothing anew: mount, light and noise are those of the calibration.
class OfflineReport {
 public:
  explicit OfflineReport(const InitializerConfig& config);

  void add(const AssociationOutcome& outcome);
  /// @param result  of the calibration at its end
  Review conclude(const CalibrationResult& result) const;

 private:
  InitializerConfig config_;
  std::vector<AssociationOutcome> outcomes_;  ///< since the light was lost for the last time
  ObservationRecord record_;                  ///< of those with a bearing
  OdometryIncrement motion_since_observation_;
};

}  // namespace bearing_calibration::core
