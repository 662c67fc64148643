#include "bearing_calibration_ros/result_saver.h"

#include <ros/console.h>
#include <ros/init.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/output/result_store.h"
#include "bearing_calibration_ros/result_saving.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

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
  const bool has_converged = is_converged && !was_converged_;
  was_converged_ = is_converged;
  const std::optional<SavingOutcome> outcome = has_converged ? saveUnasked() : std::nullopt;
  if (outcome) report("CONVERGED", *outcome);
  if (!has_converged) return;
  for (const std::string& sentence : core::qualityInWords(seen_)) {
    ROS_INFO_NAMED(name_, "CONVERGED: %s", sentence.c_str());
  }
}

SavingOutcome ResultSaver::save() {
  see();
  const std::lock_guard<std::mutex> lock(mutex_);
  return store(true);
}

std::string ResultSaver::saveBeforeReset() {
  std::string message;
  const std::string error = thrownBy([&] {
    see();
    message = saveUnasked().value_or(SavingOutcome{}).message;
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
  const bool is_same = newest.state == seen_.state && newest.stamp == seen_.stamp &&
                       newest.bearings_used == seen_.bearings_used;
  if (!is_same) saved_.reset();
  seen_ = newest;
}

void ResultSaver::onPeriod(const ros::WallTimerEvent&) {
  const std::lock_guard<std::timed_mutex> callback_lock(*callback_mutex_);
  guarded("save period", [this] {
    see();
    const std::optional<SavingOutcome> outcome = saveUnasked();
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
    const SavingOutcome nothing{true, "nothing that may be trusted was found, nothing is saved"};
    report("at the end", saveUnasked().value_or(nothing));
  });
}

std::optional<SavingOutcome> ResultSaver::saveUnasked() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!core::mayBeTrusted(seen_.state)) return std::nullopt;
  if (saved_ && std::filesystem::exists(core::resultPathIn(config_.output.folder))) return saved_;
  return store(false);
}

SavingOutcome ResultSaver::store(bool even_if_worse) {
  const auto saved = savedFrom(seen_, config_, name_, inputs_);
  if (!saved) {
    return {false, std::string("there is no estimate to save yet: ") + core::nameOf(seen_.state)};
  }
  core::SavingTerms terms;
  terms.targets = config_.calibrator.converged;
  terms.reset_between = expects_another_mount_;
  terms.even_if_worse = even_if_worse;
  const core::StoredResult stored = core::storeResult(config_.output.folder, *saved, terms);
  if (stored.is_foremost) expects_another_mount_ = false;
  if (stored.success) saved_ = {true, stored.message};
  return {stored.success, stored.message};
}

void ResultSaver::guarded(const char* when, const std::function<void()>& work) const {
  const std::string error = thrownBy(work);
  if (!error.empty()) ROS_ERROR_NAMED(name_, "%s: not saved: %s", when, error.c_str());
}

void ResultSaver::report(const std::string& when, const SavingOutcome& outcome) const {
  const std::string text = when + (outcome.success ? ": " : ": not saved: ") + outcome.message;
  if (!ros::ok()) {  // and so is the log
    std::fprintf(stderr, "%s: %s\n", name_.c_str(), text.c_str());
  } else if (outcome.success) {
    ROS_INFO_NAMED(name_, "%s", text.c_str());
    std::fflush(stdout);  // a signal ends the process without
  } else {
    ROS_WARN_NAMED(name_, "%s", text.c_str());
  }
}

}  // namespace bearing_calibration_ros
