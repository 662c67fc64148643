#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <string>

#include "bearing_calibration_ros/input_watch.h"

namespace bearing_calibration_ros {

/// What the bearing adapter has got and refused since its start, for people.
class AdapterDiagnostics {
 public:
  void countMessage() {
    ++messages_;
    silence_.saw(ros::SteadyTime::now().toSec());
  }
  void countPublished(std::size_t candidates) { with_candidates_ += candidates > 0 ? 1 : 0; }
  void countRefused(const std::string& kind) {
    ++refused_[kind];
    refused_of_late_ = kind;
  }

  /// A warning when nothing comes or something was refused since the last call; fine otherwise.
  void fill(const std::string& topic, diagnostic_updater::DiagnosticStatusWrapper* status) {
    using Status = diagnostic_msgs::DiagnosticStatus;
    const bool is_silent = silence_.isSilent(ros::SteadyTime::now().toSec());
    std::string warning = is_silent ? "nothing comes on " + topic : std::string();
    if (!refused_of_late_.empty()) warning = topic + " is refused: " + refused_of_late_;
    status->summary(warning.empty() ? Status::OK : Status::WARN,
                    warning.empty() ? topic + " is read" : warning);
    status->add("messages", messages_);
    status->add("messages with a candidate", with_candidates_);
    for (const auto& [kind, count] : refused_) status->add("refused: " + kind, count);
    refused_of_late_.clear();
  }

 private:
  std::uint64_t messages_ = 0;
  std::uint64_t with_candidates_ = 0;
  std::map<std::string, std::uint64_t> refused_;
  std::string refused_of_late_;
  SilenceWatch silence_;
};

}  // namespace bearing_calibration_ros
