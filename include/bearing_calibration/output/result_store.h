#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/judge/convergence_config.h"
#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

/// How a result is saved, besides the rule (see saving_rule.h).
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
/// stands for (see OwnedFolder), by the rule of saving_rule.h. A result.yaml that is there and
/// cannot be read is kept, numbered, as one that contradicts.
StoredResult storeResult(const std::string& wanted, const SavedCalibration& fresh,
                         const SavingTerms& terms);

/// Writes files of a run that has found nothing: into a numbered folder where there is a result.
StoredResult storeWithoutResult(const std::string& wanted, const std::vector<FileText>& files);

/// The path of the result.yaml that `wanted` stands for, whether it is there or not.
std::string resultPathIn(const std::string& wanted);

}  // namespace bearing_calibration::core
