#pragma once

#include <cstdint>
#include <string>

#include "bearing_calibration/judge/convergence_config.h"
#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

/// Whether a state's mount may be used: CONVERGED or CONVERGING.
bool mayBeTrusted(CalibrationState state);

/// Why a result was not measured with these frames and wheels; empty when it was.
std::string whyOfAnotherRobot(const SavedCalibration& saved, const std::string& base_frame,
                              const std::string& sensor_frame, const DriveGeometry& drive);

/// What becomes of a result that is to be saved where one lies already.
enum class SavingDecision : std::uint8_t {
  kReplaces,    ///< it takes the place of the old one
  kTakesPlace,  ///< it is result.yaml now, and the old one is kept beside it, numbered
  kGivesWay,    ///< the old one stays result.yaml
};

struct SavingVerdict {
  SavingDecision decision = SavingDecision::kReplaces;
  std::string why;  ///< half a sentence about the old one, as "it is CONVERGED, this one is not"
};

/// Two honest results of one mount contradict each other once in so many pairs: chi-square of their
/// difference, by the sum of their covariances, above 21.1 with 3 degrees of freedom.
inline constexpr double kContradictionFalseAlarm = 1e-4;

/// The rule, the same for the live node and for calibrate_bag. The first line that holds decides:
///
/// 1. A result that may not be trusted gives way to one that may.
/// 2. One of other frames or wheels, one after a reset, and one that contradicts the old one takes
///    its place, and the old one is kept.
/// 3. Of two results of one mount the better state wins: CONVERGED, CONVERGING, any other.
/// 4. Then the one whose worst standard deviation of x, y and yaw, relative to the targets, is the
///    smaller; where they are equal the newer.
SavingVerdict judgeSaving(const SavedCalibration& old, const SavedCalibration& fresh,
                          const ConvergenceConfig& targets, bool reset_between);

}  // namespace bearing_calibration::core
