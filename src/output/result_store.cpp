#include "bearing_calibration/output/result_store.h"

#include <algorithm>
#include <exception>
#include <filesystem>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/output/result_export.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {
namespace {

constexpr char kResultName[] = "result.yaml";

int rankOf(CalibrationState state) {
  if (state == CalibrationState::kConverged) return 2;
  return mayBeTrusted(state) ? 1 : 0;
}

/// The largest standard deviation of x, y and yaw, as a multiple of its target.
double worstStddev(const MountEstimate& mount, const ConvergenceConfig& targets) {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  return std::max(stddev.head<2>().maxCoeff() / targets.position_stddev_m,
                  stddev.z() / targets.yaw_stddev_rad);
}

/// Why both are kept; empty when they are of one mount, as far as can be told.
std::string whyBothAreKept(const SavedCalibration& old, const SavedCalibration& fresh,
                           bool reset_between) {
  std::string why =
      whyOfAnotherRobot(old, fresh.base_frame, fresh.sensor_frame, fresh.provenance.drive);
  if (!why.empty()) return why;
  if (reset_between) return "the calibration was reset since";
  static const double kLargest = chiSquareQuantile(1.0 - kContradictionFalseAlarm, kMountSize);
  const double chi_square = disagreement(old.mount(), fresh.mount());
  if (chi_square <= kLargest) return {};
  return formatted("it contradicts this one: chi-square %.1f of their difference, above %.1f",
                   chi_square, kLargest);
}

std::string resultIn(const std::string& folder) {
  return std::filesystem::path(folder) / kResultName;
}

std::vector<FileText> filesOf(const SavedCalibration& calibration, const SavingTerms& terms) {
  std::vector<FileText> files{{kResultName, resultText(calibration)}};
  for (const FileText& form : formsOf(calibration)) files.push_back(form);
  for (const FileText& file : terms.more) files.push_back(file);
  return files;
}

SavingVerdict judge(const OwnedFolder& folder, const SavedCalibration& fresh,
                    const SavingTerms& terms) {
  if (!folder.owns(kResultName)) return {};
  const ResultFileContent old = readResultFile(resultIn(folder.path()));
  if (!old.calibration) return {SavingDecision::kTakesPlace, old.error};
  return judgeSaving(*old.calibration, fresh, terms.targets, terms.reset_between);
}

StoredResult store(OwnedFolder& folder, const SavedCalibration& fresh, const SavingTerms& terms) {
  const SavingVerdict verdict = judge(folder, fresh, terms);
  StoredResult stored;
  stored.success = true;
  if (verdict.decision == SavingDecision::kGivesWay) {
    stored.message = resultIn(folder.path()) + " stays: " + verdict.why;
    if (terms.even_if_worse) {
      stored.folder = folder.writeNumbered(filesOf(fresh, terms));
      stored.message += "; this one is written to " + resultIn(stored.folder);
    } else {
      stored.success = mayBeTrusted(fresh.result.state);
    }
    return stored;
  }
  std::string kept;
  if (verdict.decision == SavingDecision::kTakesPlace) {
    kept = "; what was there before is kept in " + folder.copyNumbered() + ": " + verdict.why;
  }
  stored.folder = folder.replace(filesOf(fresh, terms));
  stored.is_foremost = stored.folder == folder.path();
  stored.message = "written to " + resultIn(stored.folder) + kept;
  return stored;
}

/// What `work` makes of the folder; what the file system refuses becomes the message.
template <class Work>
StoredResult in(const std::string& wanted, const Work& work) {
  try {
    OwnedFolder folder(wanted);
    return work(folder);
  } catch (const std::exception& error) {
    return {false, false, "", error.what()};
  }
}

}  // namespace

std::string whyOfAnotherRobot(const SavedCalibration& saved, const std::string& base_frame,
                              const std::string& sensor_frame, const DriveGeometry& drive) {
  const DriveGeometry& then = saved.provenance.drive;
  if (saved.base_frame != base_frame || saved.sensor_frame != sensor_frame) {
    return "it is of " + saved.base_frame + " and " + saved.sensor_frame;
  }
  if (then.wheel_separation_m != drive.wheel_separation_m ||
      then.left_wheel_radius_m != drive.left_wheel_radius_m ||
      then.right_wheel_radius_m != drive.right_wheel_radius_m) {
    return "it was measured with other wheels/separation, left_radius or right_radius";
  }
  return {};
}

SavingVerdict judgeSaving(const SavedCalibration& old, const SavedCalibration& fresh,
                          const ConvergenceConfig& targets, bool reset_between) {
  const int lead = rankOf(fresh.result.state) - rankOf(old.result.state);
  const std::string states =
      formatted("it is %s, this one %s", nameOf(old.result.state), nameOf(fresh.result.state));
  if (mayBeTrusted(old.result.state) && !mayBeTrusted(fresh.result.state)) {
    return {SavingDecision::kGivesWay, states};
  }
  const std::string why = whyBothAreKept(old, fresh, reset_between);
  if (!why.empty()) return {SavingDecision::kTakesPlace, why};
  if (lead != 0) {
    return {lead > 0 ? SavingDecision::kReplaces : SavingDecision::kGivesWay, states};
  }
  const double before = worstStddev(old.mount(), targets);
  const double now = worstStddev(fresh.mount(), targets);
  return {now <= before ? SavingDecision::kReplaces : SavingDecision::kGivesWay,
          formatted("its worst standard deviation is %.2f of its target, this one's %.2f", before,
                    now)};
}

StoredResult storeResult(const std::string& wanted, const SavedCalibration& fresh,
                         const SavingTerms& terms) {
  return in(wanted, [&](OwnedFolder& folder) { return store(folder, fresh, terms); });
}

StoredResult storeWithoutResult(const std::string& wanted, const std::vector<FileText>& files) {
  return in(wanted, [&](OwnedFolder& folder) {
    const bool has_result = folder.owns(kResultName);
    StoredResult stored;
    stored.success = true;
    stored.folder = has_result ? folder.writeNumbered(files) : folder.replace(files);
    stored.message = "written to " + stored.folder;
    if (has_result) stored.message += "; " + resultIn(folder.path()) + " is of an earlier run";
    return stored;
  });
}

std::string resultPathIn(const std::string& wanted) { return resultIn(OwnedFolder::find(wanted)); }

}  // namespace bearing_calibration::core
