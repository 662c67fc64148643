#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/judge/convergence_judge.h"
#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

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

/// How a result is saved, besides the rule.
struct SavingTerms {
  ConvergenceConfig targets;   ///< what standard deviations are compared with
  bool reset_between = false;  ///< the owner has said that what is there may be of another mount
  bool even_if_worse = false;  ///< one that gives way is written, too, into a numbered folder
  std::vector<FileText> more;  ///< files that go with the result
};

/// What became of a result.
struct StoredResult {
  bool success = false;      ///< this result, or a better one of its mount, lies in the folder
  bool is_foremost = false;  ///< it is the folder's result.yaml now
  std::string folder;        ///< where it was written; empty: nowhere
  std::string message;       ///< a sentence: the files that were written, or why they were not
};

/// Writes result.yaml and what is made of it (see result_export.h) into the folder that `wanted`
/// stands for (see OwnedFolder), by the rule. A result.yaml that is there and cannot be read is
/// kept, numbered, as one that contradicts.
StoredResult storeResult(const std::string& wanted, const SavedCalibration& fresh,
                         const SavingTerms& terms);

/// Writes files of a run that has found nothing: into a numbered folder where there is a result.
StoredResult storeWithoutResult(const std::string& wanted, const std::vector<FileText>& files);

/// The path of the result.yaml that `wanted` stands for, whether it is there or not.
std::string resultPathIn(const std::string& wanted);

}  // namespace bearing_calibration::core
