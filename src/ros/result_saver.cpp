#include "bearing_calibration_ros/result_saver.h"

#include <ros/common.h>
#include <ros/console.h>
#include <ros/time.h>

#include <boost/date_time/posix_time/posix_time.hpp>
#include <chrono>
#include <filesystem>
#include <map>
#include <utility>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration_ros/result_messages.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {
namespace {

std::string wallTimeText() {
  return boost::posix_time::to_iso_extended_string(ros::WallTime::now().toBoost()) + "Z";
}

std::map<std::string, std::string> versions() {
  return {
      {"bearing_calibration", '"' + std::string(BEARING_CALIBRATION_VERSION) + '"'},
      {"roscpp",
       core::formatted("\"%d.%d.%d\"", ROS_VERSION_MAJOR, ROS_VERSION_MINOR, ROS_VERSION_PATCH)},
      {"eigen", core::formatted("\"%d.%d.%d\"", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                                EIGEN_MINOR_VERSION)},
  };
}

}  // namespace

std::optional<core::SavedCalibration> savedFrom(const core::CalibrationResult& result,
                                                const CalibrationNodeConfig& config,
                                                const std::string& program,
                                                const std::string& source) {
  if (!result.estimate) return std::nullopt;
  core::SavedCalibration saved;
  saved.result = result;
  saved.base_frame = config.frames.base;
  saved.sensor_frame = config.frames.sensor;
  saved.lasting = core::lastingPart(*result.estimate);
  saved.unestimated = config.unestimated_mount;
  saved.rejections = rejectionsText(result, 0);
  saved.provenance = {program,    wallTimeText(), source, config.calibrator.drive,
                      versions(), config.texts};
  return saved;
}

EarlierResult readEarlierResult(const CalibrationNodeConfig& config) {
  const std::string path = core::resultPathIn(config.output.folder);
  if (!std::filesystem::exists(path)) return {std::nullopt, "nothing to resume: no " + path};
  const core::ResultFileContent content = core::readResultFile(path);
  if (!content.calibration) return {std::nullopt, "not resumed: " + content.error};
  const core::SavedCalibration& saved = *content.calibration;
  std::string why = core::whyOfAnotherRobot(saved, config.frames.base, config.frames.sensor,
                                            config.calibrator.drive);
  if (why.empty() && !core::mayBeTrusted(saved.result.state)) {
    why = std::string("it was ") + core::nameOf(saved.result.state) + " when it was written";
  }
  if (!why.empty()) return {std::nullopt, "not resumed: " + path + ": " + why};
  return {saved.lasting, "resumed from " + path + ", written " + saved.provenance.written_at};
}

ResultSaver::ResultSaver(ros::NodeHandle& node_handle, const CalibrationNodeConfig& config,
                         std::string name, std::string inputs, Source newest,
                         std::timed_mutex* callback_mutex)
    : config_(config),
      name_(std::move(name)),
      inputs_(std::move(inputs)),
      newest_(std::move(newest)),
      callback_mutex_(callback_mutex),
      shutdown_hook_(std::make_unique<ShutdownHook>([this] { saveAtEnd(); })) {
  if (config_.output.save_period_s <= 0.0) return;
  timer_ = node_handle.createWallTimer(ros::WallDuration(config_.output.save_period_s),
                                       &ResultSaver::onPeriod, this);
}

ResultSaver::~ResultSaver() {
  timer_.stop();
  shutdown_hook_.reset();
  saveAtEnd();
}

void ResultSaver::check() {
  see();
  const bool is_converged = seen_.state == core::CalibrationState::kConverged;
  const bool had_converged = std::exchange(was_converged_, is_converged);
  if (!is_converged || had_converged) return;
  if (const auto outcome = saveUnasked()) report("CONVERGED", *outcome);
  for (const std::string& sentence : core::qualityInWords(seen_)) {
    ROS_INFO_NAMED(name_, "CONVERGED: %s", sentence.c_str());
  }
}

core::StoredResult ResultSaver::save() {
  see();
  const std::lock_guard<std::mutex> lock(mutex_);
  return store(true);
}

std::string ResultSaver::saveBeforeReset() {
  std::string message;
  const std::string error = thrownBy([&] {
    see();
    message = saveUnasked().value_or(core::StoredResult{}).message;
  });
  const std::lock_guard<std::mutex> lock(mutex_);
  seen_ = {};
  saved_.reset();
  was_converged_ = false;
  return error.empty() ? message : error;
}

void ResultSaver::see() {
  const core::CalibrationResult newest = newest_();
  if (newest.state == core::CalibrationState::kPaused) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  // A fit that is taken over late says more of the bearings that were there before.
  const bool is_same = newest.state == seen_.state && newest.stamp == seen_.stamp &&
                       newest.bearings_used == seen_.bearings_used &&
                       newest.base_from_sensor == seen_.base_from_sensor;
  if (!is_same) saved_.reset();
  seen_ = newest;
}

void ResultSaver::onPeriod(const ros::WallTimerEvent&) {
  const std::lock_guard<std::timed_mutex> callback_lock(*callback_mutex_);
  guarded("save period", [this] {
    see();
    const std::optional<core::StoredResult> outcome = saveUnasked();
    if (outcome && !outcome->success) report("save period", *outcome);
  });
}

void ResultSaver::saveAtEnd() {
  constexpr std::chrono::milliseconds kPatience{500};
  if (has_ended_.exchange(true)) return;
  guarded("at the end", [&] {
    {
      const std::unique_lock<std::timed_mutex> callback_lock(*callback_mutex_, kPatience);
      if (callback_lock) see();
    }
    const core::StoredResult nothing{true, false, "",
                                     "nothing that may be trusted was found, nothing is saved"};
    report("at the end", saveUnasked().value_or(nothing));
  });
}

std::optional<core::StoredResult> ResultSaver::saveUnasked() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!core::mayBeTrusted(seen_.state)) return std::nullopt;
  if (saved_ && std::filesystem::exists(core::resultPathIn(config_.output.folder))) return saved_;
  return store(false);
}

core::StoredResult ResultSaver::store(bool even_if_worse) {
  const auto saved = savedFrom(seen_, config_, name_, inputs_);
  if (!saved) {
    return {false, false, "",
            std::string("there is no estimate to save yet: ") + core::nameOf(seen_.state)};
  }
  core::SavingTerms terms;
  terms.targets = config_.calibrator.converged;
  terms.reset_between = expects_another_mount_;
  terms.even_if_worse = even_if_worse;
  const core::StoredResult stored = core::storeResult(config_.output.folder, *saved, terms);
  if (stored.is_foremost) expects_another_mount_ = false;
  if (stored.success) saved_ = stored;
  return stored;
}

void ResultSaver::guarded(const char* when, const std::function<void()>& work) const {
  const std::string error = thrownBy(work);
  if (!error.empty()) ROS_ERROR_NAMED(name_, "%s: not saved: %s", when, error.c_str());
}

void ResultSaver::report(const std::string& when, const core::StoredResult& outcome) const {
  sayAtTheEnd(name_, outcome.success,
              when + (outcome.success ? ": " : ": not saved: ") + outcome.message);
}

}  // namespace bearing_calibration_ros
