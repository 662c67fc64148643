#pragma once

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
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
/// as left.light_detection.yaml (no part of a name has a point): several nodes may share a folder,
/// with results too. A file of an earlier run stays until as many values are learnt as it has.
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
      seen_ = learner;
    }
    if (learnt > std::exchange(learnt_, std::max(learnt, learnt_))) save();
  }

 private:
  static std::string fileOf(std::string node) {
    std::replace(node.begin(), node.end(), '/', '.');
    return node.substr(node.find_first_not_of('.')) + ".yaml";
  }

  /// Of an earlier run; of nothing where there is none.
  bool isBetter(const std::string& path) const {
    std::ostringstream earlier;
    earlier << std::ifstream(path).rdbuf();
    return saved_.empty() && seen_->learntValuesIn(earlier.str()) > seen_->learntValues();
  }

  void save() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!seen_) return;
    const std::string text = core::yamlOf(*seen_);
    if (text == saved_) return;
    std::string said = "the optics as learnt are in ";
    const std::string error = thrownBy([&] {
      core::OwnedFolder folder(folder_);
      const std::string path = folder.path() + "/" + file_;
      if (isBetter(path)) {
        throw std::runtime_error("more values are learnt in " + path +
                                 ": remove it if lens or mirror have changed");
      }
      said += folder.add({file_, text, true}) + "/" + file_;
      saved_ = text;
    });
    if (!error.empty()) said = "the optics are not saved: " + error;
    sayAtTheEnd(node_, error.empty(), said);
  }

  const std::string folder_, node_, file_;
  int learnt_ = 0;                               ///< values, at most
  std::mutex mutex_;                             ///< of what follows
  std::optional<core::OpticsLearner> seen_;      ///< none: nothing is learnt yet
  std::string saved_;                            ///< of that, in this run
  std::unique_ptr<ShutdownHook> shutdown_hook_;  ///< last, so that what it uses is there
};

}  // namespace bearing_calibration_ros
