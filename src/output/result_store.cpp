#include "bearing_calibration/output/result_store.h"

#include <exception>
#include <filesystem>

#include "bearing_calibration/output/result_export.h"
#include "bearing_calibration/output/saving_rule.h"

namespace bearing_calibration::core {
namespace {

constexpr char kResultName[] = "result.yaml";

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
  if (!folder.owns(kResultName)) return {SavingDecision::kReplaces, ""};
  const ResultFileContent old = readResultFile(resultIn(folder.path()));
  if (!old.calibration) return {SavingDecision::kTakesPlace, old.error};
  return judgeSaving(*old.calibration, fresh, terms.targets, terms.reset_between);
}

StoredResult giveWay(OwnedFolder* folder, const SavedCalibration& fresh, const SavingTerms& terms,
                     const std::string& why) {
  StoredResult stored;
  stored.success = mayBeTrusted(fresh.state);
  stored.message = resultIn(folder->path()) + " stays: " + why;
  if (!terms.even_if_worse) return stored;
  stored.success = true;
  stored.folder = folder->writeNumbered(filesOf(fresh, terms));
  stored.message += "; this one is written to " + resultIn(stored.folder);
  return stored;
}

StoredResult store(OwnedFolder* folder, const SavedCalibration& fresh, const SavingTerms& terms) {
  const SavingVerdict verdict = judge(*folder, fresh, terms);
  if (verdict.decision == SavingDecision::kGivesWay) {
    return giveWay(folder, fresh, terms, verdict.why);
  }
  std::string kept;
  if (verdict.decision == SavingDecision::kTakesPlace) {
    kept = "; what was there before is kept in " + folder->copyNumbered() + ": " + verdict.why;
  }
  StoredResult stored;
  stored.folder = folder->replace(filesOf(fresh, terms));
  stored.is_foremost = stored.folder == folder->path();
  stored.success = true;
  stored.message = "written to " + resultIn(stored.folder) + kept;
  return stored;
}

}  // namespace

StoredResult storeResult(const std::string& wanted, const SavedCalibration& fresh,
                         const SavingTerms& terms) {
  try {
    OwnedFolder folder(wanted);
    return store(&folder, fresh, terms);
  } catch (const std::exception& error) {  // of the file system
    StoredResult failed;
    failed.message = error.what();
    return failed;
  }
}

StoredResult storeWithoutResult(const std::string& wanted, const std::vector<FileText>& files) {
  StoredResult stored;
  try {
    OwnedFolder folder(wanted);
    const bool has_result = folder.owns(kResultName);
    stored.folder = has_result ? folder.writeNumbered(files) : folder.replace(files);
    stored.success = true;
    stored.message = "written to " + stored.folder;
    if (has_result) stored.message += "; " + resultIn(folder.path()) + " is of an earlier run";
  } catch (const std::exception& error) {
    stored.message = error.what();
  }
  return stored;
}

std::string resultPathIn(const std::string& wanted) { return resultIn(OwnedFolder::find(wanted)); }

}  // namespace bearing_calibration::core
