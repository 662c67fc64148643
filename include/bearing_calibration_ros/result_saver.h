#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "bearing_calibration/output/result.h"
#include "bearing_calibration/output/result_file.h"
#include "bearing_calibration/output/result_store.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/shutdown_hook.h"

namespace bearing_calibration_ros {

/// A result as it is saved; none before there is an estimate.
/// @param program,source  what calls, and where its measurements come from: provenance
std::optional<core::SavedCalibration> savedFrom(const core::CalibrationResult& result,
                                                const CalibrationNodeConfig& config,
                                                const std::string& program,
                                                const std::string& source);

/// What is in the configured folder's result.yaml to go on from.
struct EarlierResult {
  std::optional<core::StateEstimate> lasting;
  std::string message;  ///< what was taken up, or why nothing was
};

/// Refuses a file that is missing, corrupt or foreign, was measured with other wheels or between
/// other frames, or was not trusted when it was written.
EarlierResult readEarlierResult(const CalibrationNodeConfig& config);

/// Saves what a node finds, by the rule of result_store.h: when somebody asks for it, when it has
/// become CONVERGED, every output/save_period, before it is forgotten, and at the node's end, by a
/// signal too. Without being asked only what may be trusted, and only what has changed.
///
/// Threading: all functions are called by the node's callbacks, which hold `callback_mutex`. The
/// end runs in a thread of its own. It waits for the callback under way, but not for long: then it
/// saves what was seen last.
class ResultSaver {
 public:
  using Source = std::function<core::CalibrationResult()>;

  /// @param name    of the node: for the log, and in the file
  /// @param inputs  where the measurements come from, for the file
  /// @param newest  the calibration's result
  ResultSaver(ros::NodeHandle& node_handle, const CalibrationNodeConfig& config, std::string name,
              std::string inputs, Source newest, std::timed_mutex* callback_mutex);
  /// Saves.
  ~ResultSaver();
  ResultSaver(const ResultSaver&) = delete;
  ResultSaver& operator=(const ResultSaver&) = delete;

  /// Sees the newest result, which should be done once a second and before a pause (what is known
  /// during one is what was known before it), and saves it when it has become CONVERGED.
  void check();
  /// Saves because somebody asks for it: a result that gives way to a better one is written, too.
  core::StoredResult save();
  /// Saves what is to be forgotten. @returns what became of it; empty where there was nothing
  std::string saveBeforeReset();
  /// Somebody says that the mount may be another one than that of what is saved.
  void expectAnotherMount() { expects_another_mount_ = true; }

 private:
  void see();
  void onPeriod(const ros::WallTimerEvent& event);
  void saveAtEnd();
  std::optional<core::StoredResult> saveUnasked();
  core::StoredResult store(bool even_if_worse);
  void guarded(const char* when, const std::function<void()>& work) const;
  void report(const std::string& when, const core::StoredResult& outcome) const;

  const CalibrationNodeConfig config_;
  const std::string name_, inputs_;
  const Source newest_;
  std::timed_mutex* const callback_mutex_;

  std::mutex mutex_;  ///< of what follows
  core::CalibrationResult seen_;
  std::optional<core::StoredResult> saved_;  ///< what was seen; none: not yet
  std::atomic<bool> expects_another_mount_{false};

  bool was_converged_ = false;
  std::atomic<bool> has_ended_{false};
  std::unique_ptr<ShutdownHook> shutdown_hook_;
  ros::WallTimer timer_;
};

}  // namespace bearing_calibration_ros
