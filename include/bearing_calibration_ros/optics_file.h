#pragma once

#include <ros/console.h>
#include <ros/init.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/vision/optics_learner.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/shutdown_hook.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

/// Writes lens and mirror as learnt from the light: when one of their values is learnt, and at the
/// node's end, by a signal too. Nothing before the first is learnt. The file has the node's name,
/// as left.light_detection.yaml (no part of a name has a point): several nodes may share a folder.
///
/// Threading: the end runs in a thread of its own; it saves what was seen last.
class OpticsFile {
 public:
  /// @param node  its whole name
  OpticsFile(std::string folder, std::string node)
      : folder_(std::move(folder)),
        node_(std::move(node)),
        file_(fileOf(node_)),
        shutdown_hook_(std::make_unique<ShutdownHook>([this] { save(); })) {}
  ~OpticsFile() {
    shutdown_hook_.reset();
    save();
  }
  OpticsFile(const OpticsFile&) = delete;
  OpticsFile& operator=(const OpticsFile&) = delete;

  /// To be called once a second.
  void see(const core::OpticsLearner& learner) {
    const int learnt = learner.learntValues();
    if (learnt == 0) return;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      text_ = core::yamlOf(learner);
    }
    if (learnt > std::exchange(learnt_, std::max(learnt, learnt_))) save();
  }

 private:
  static std::string fileOf(std::string node) {
    std::replace(node.begin(), node.end(), '/', '.');
    return node.substr(node.find_first_not_of('.')) + ".yaml";
  }

  void save() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (text_ == saved_) return;
    std::string said = "the optics as learnt are in ";
    const std::string error = thrownBy([&] {
      said += core::OwnedFolder(folder_).add({file_, text_}) + "/" + file_;
      saved_ = text_;
    });
    if (!error.empty()) said = "the optics are not saved: " + error;
    if (ros::ok()) {
      ROS_INFO_NAMED(node_, "%s", said.c_str());
    } else {  // and so is the log
      std::fprintf(stderr, "%s: %s\n", node_.c_str(), said.c_str());
    }
  }

  const std::string folder_, node_, file_;
  int learnt_ = 0;    ///< values, at most
  std::mutex mutex_;  ///< of what follows
  std::string text_;
  std::string saved_;                            ///< of that
  std::unique_ptr<ShutdownHook> shutdown_hook_;  ///< last, so that what it uses is there
};

}  // namespace bearing_calibration_ros
