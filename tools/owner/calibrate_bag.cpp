// Finds the mount in bags, without a ROS master: calibrate_bag --help

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <set>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/output/yaml_writer.h"
#include "bearing_calibration_ros/result_messages.h"
#include "bearing_calibration_ros/thrown.h"
#include "tools/common/command_line.h"
#include "tools/common/parallel.h"
#include "tools/owner/bag_calibration.h"
#include "tools/owner/bag_files.h"
#include "tools/owner/calibrate_bag_arguments.h"
#include "tools/owner/mount_comparison.h"
#include "tools/owner/progress_bar.h"

namespace bearing_calibration::core {
namespace {

namespace fs = std::filesystem;
namespace ros_side = bearing_calibration_ros;

constexpr char kComparison[] = "comparison.yaml";
constexpr char kContents[] = "calibrations.yaml";

enum ExitStatus : int {
  kConverged = 0,
  kFailed = 1,
  kDegenerate = 3,
  kUncertain = 4,
  kDisagreement = 5,
};

/// A job with what came out of it.
struct Done {
  BagJob job;
  std::string folder;  ///< as wanted
  BagOutcome outcome;
  StoredResult stored;
  std::string error;  ///< a sentence; empty when the outcome holds
};

/// What is to be done with one bag: a job for each light.
std::vector<Done> listJobs(const std::string& bag, const CalibrateBagArguments& arguments,
                           const BagSetup& setup) {
  const std::string name = fs::path(bag).stem();
  std::vector<Done> jobs;
  try {
    std::vector<std::int32_t> lights(arguments.light_ids.begin(), arguments.light_ids.end());
    if (arguments.each_light) lights = listLights(bag, setup);
    if (lights.empty()) jobs.push_back({{bag, std::nullopt, name}, {}, {}, {}, {}});
    for (const std::int32_t light : lights) {
      jobs.push_back({{bag, light, name + "_light_" + std::to_string(light)}, {}, {}, {}, {}});
    }
  } catch (const std::exception& error) {
    jobs.push_back({{bag, std::nullopt, name}, {}, {}, {}, error.what()});
  }
  return jobs;
}

/// The only job writes into the output's folder itself, several write into folders below it.
void nameFolders(const std::string& output, std::vector<Done>* all) {
  if (all->size() > 1) OwnedFolder(output).claim();
  const std::string folder = OwnedFolder::find(output);
  std::set<std::string> names;
  for (Done& done : *all) {  // bags of one name may lie in several folders
    const std::string name = done.job.name;
    for (int i = 2; !names.insert(done.job.name).second; ++i) {
      done.job.name = name + "_" + std::to_string(i);
    }
    done.folder = all->size() == 1 ? fs::path(folder) : fs::path(folder) / done.job.name;
  }
}

std::uint64_t countMessages(const BagSetup& setup, std::vector<Done>* all) {
  std::uint64_t messages = 0;
  for (Done& done : *all) {
    try {
      if (done.error.empty()) messages += countMessages(done.job, setup);
    } catch (const std::exception& error) {
      done.error = error.what();
    }
  }
  return messages;
}

void calibrate(const BagSetup& setup, std::atomic<std::uint64_t>* progress, Done* done) {
  if (!done->error.empty()) return;
  try {
    BagSetup own = setup;
    own.calibration.output.folder = done->folder;
    done->outcome = calibrateBag(done->job, own, progress);
    done->stored = storeBagFiles(done->folder, done->job, own, done->outcome);
    if (!done->stored.success) done->error = done->stored.message;
  } catch (const std::exception& error) {
    done->error = error.what();
  }
}

ExitStatus statusOf(const Done& done) {
  if (!done.error.empty()) return kFailed;
  switch (done.outcome.result.state) {
    case CalibrationState::kConverged:
      return kConverged;
    case CalibrationState::kConverging:
      return kUncertain;
    case CalibrationState::kInitialising:
    case CalibrationState::kDegenerateMotion:
      return kDegenerate;
    default:
      return kFailed;
  }
}

void printMount(const MountEstimate& mount) {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  std::printf("  x   %9.4f +- %.4f m\n  y   %9.4f +- %.4f m\n", mount.mean.x(), stddev.x(),
              mount.mean.y(), stddev.y());
  std::printf("  yaw %9.4f +- %.4f rad  (%.2f +- %.2f deg)\n", mount.mean.z(), stddev.z(),
              degreesFromRadians(mount.mean.z()), degreesFromRadians(stddev.z()));
}

std::string whatLiesIn(const std::string& folder) {
  const std::string path = resultPathIn(folder);
  return fs::exists(path) ? "; " + path + " is of an earlier run" : "";
}

void print(const Done& done) {
  if (!done.error.empty()) {
    std::printf("%s: FAILED: %s\n  nothing was written%s\n", done.job.name.c_str(),
                done.error.c_str(), whatLiesIn(done.folder).c_str());
    return;
  }
  const BagOutcome& outcome = done.outcome;
  const CalibrationResult& result = outcome.result;
  std::printf("%s: %s: %s\n", done.job.name.c_str(), nameOf(result.state), result.advice.c_str());
  if (result.base_from_sensor) printMount(*result.base_from_sensor);
  for (const std::string& sentence : qualityInWords(result)) {
    std::printf("  %s\n", sentence.c_str());
  }
  for (const std::string& sentence : inWords(outcome.review.sensor)) {
    std::printf("  %s\n", sentence.c_str());
  }
  std::printf("  %u bearings used, %u gated, in %.1f m and %.1f rad\n", result.bearings_used,
              result.bearings_gated, result.distance_travelled_m, result.rotation_travelled_rad);
  const BagTimes& times = outcome.times;
  std::printf("  %.1f s: reading %.1f s, detection %.1f s (%llu images), estimation %.1f s\n",
              times.whole, times.reading, times.detection,
              static_cast<unsigned long long>(outcome.images), times.estimation);
  for (const std::string& warning : outcome.warnings) std::printf("  ! %s\n", warning.c_str());
  const std::string refused = ros_side::rejectionsText(result, 0);
  if (!refused.empty()) std::printf("  ! refused or changed: %s\n", refused.c_str());
  std::printf("  %s\n", done.stored.message.c_str());
}

/// Estimates that may be compared: those that are trusted.
std::vector<NamedMount> mountsOf(const std::vector<Done>& all) {
  std::vector<NamedMount> mounts;
  for (const Done& done : all) {
    const ExitStatus status = statusOf(done);
    if (status != kConverged && status != kUncertain) continue;
    mounts.push_back({done.job.name, *done.outcome.result.base_from_sensor});
  }
  return mounts;
}

/// Writes what several jobs have in common. Their own files are there, whatever becomes of it.
ExitStatus writeTogether(const std::function<void()>& write) {
  const std::string error = ros_side::thrownBy(write);
  if (error.empty()) return kConverged;
  std::printf("%s\n", error.c_str());
  return kFailed;
}

ExitStatus compare(const std::vector<Done>& all, const std::string& folder) {
  const std::vector<NamedMount> mounts = mountsOf(all);
  if (mounts.size() < 2) {
    std::printf("\nNothing to compare: %zu of %zu estimates may be trusted.\n", mounts.size(),
                all.size());
    return kFailed;
  }
  const MountComparison comparison = compareMounts(mounts);
  std::printf("\n%s", format(mounts, comparison).c_str());
  const ExitStatus written = writeTogether([&] {
    OwnedFolder(folder).add({kComparison, toYaml(mounts, comparison)});
  });
  if (written != kConverged) return written;
  return comparison.agrees() ? kConverged : kDisagreement;
}

/// The first of the statuses that is there, from the worst on.
ExitStatus worst(const std::set<ExitStatus>& statuses) {
  for (const ExitStatus status : {kFailed, kDegenerate, kDisagreement, kUncertain}) {
    if (statuses.count(status) != 0) return status;
  }
  return kConverged;
}

std::vector<Done> runAll(const CalibrateBagArguments& arguments, const BagSetup& setup) {
  std::vector<Done> all;
  for (const std::string& bag : arguments.bags) {
    for (Done& done : listJobs(bag, arguments, setup)) all.push_back(std::move(done));
  }
  nameFolders(arguments.output_folder, &all);
  ProgressBar bar(countMessages(setup, &all), !arguments.quiet);
  forEachInParallel(all.size(), arguments.jobs,
                    [&](std::size_t i) { calibrate(setup, bar.count(), &all[i]); });
  return all;
}

bool isAnyStored(const std::vector<Done>& all) {
  return std::any_of(all.begin(), all.end(),
                     [](const Done& done) { return !done.stored.folder.empty(); });
}

/// What the report shows of several jobs: earlier runs may have left results and a comparison.
void listStored(const std::vector<Done>& all, const std::string& output) {
  OwnedFolder folder(output);
  if (folder.owns(kComparison)) fs::remove(fs::path(folder.path()) / kComparison);
  std::vector<std::string> stored;
  for (const Done& done : all) {
    if (done.stored.folder.empty()) continue;
    stored.push_back(fs::path(done.stored.folder).lexically_relative(folder.path()));
  }
  YamlWriter write;
  write.out << YAML::BeginMap;
  write("calibrations", stored);
  write.out << YAML::EndMap;
  folder.add({kContents, std::string(write.out.c_str()) + "\n"});
}

void sayHowToReport(const std::vector<Done>& all, const std::string& output) {
  const std::string folder =
      all.size() == 1 ? all.front().stored.folder : OwnedFolder::find(output);
  std::printf("\nIn %s; a report of it: rosrun bearing_calibration calibration_report %s\n",
              folder.c_str(), folder.c_str());
}

ExitStatus run(const CalibrateBagArguments& arguments) {
  const BagSetup setup =
      readBagSetup(arguments.config_files, arguments.assignments, arguments.topics);
  if (const auto why = ros_side::whyNotWritable(arguments.output_folder); !why.empty()) {
    throw boost::program_options::error("--output " + why);
  }
  const std::vector<Done> all = runAll(arguments, setup);
  std::set<ExitStatus> statuses;
  for (const Done& done : all) {
    print(done);
    statuses.insert(statusOf(done));
  }
  if (all.size() > 1 && isAnyStored(all)) {
    statuses.insert(writeTogether([&] { listStored(all, arguments.output_folder); }));
  }
  if (arguments.compare) statuses.insert(compare(all, arguments.output_folder));
  if (isAnyStored(all)) sayHowToReport(all, arguments.output_folder);
  return worst(statuses);
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  namespace package = bearing_calibration::core;
  const auto work = [&]() -> int {
    const auto arguments = package::parseCalibrateBagArguments(argc, argv);
    return arguments ? package::run(*arguments) : package::kConverged;
  };
  return package::runProgram("calibrate_bag", work, package::kUsageError);
}
