#pragma once

#include <functional>
#include <memory>
#include <string>

namespace bearing_calibration_ros {

/// Runs `speak` when somebody ends this process by SIGINT (ctrl-C, roslaunch), SIGTERM or, unless
/// it was ignored (nohup), SIGHUP (a terminal or connection that is closed), and lets the signal
/// take effect after that: when a nodelet is destroyed because of it, ROS no longer sends anything.
///
/// `speak` runs in a thread of its own, once, and may take ten seconds: roslaunch kills after 15.
/// While one of these lives the process' handlers of these signals are this class'; the last one
/// puts back what it found.
class ShutdownHook {
 public:
  explicit ShutdownHook(std::function<void()> speak);
  /// Waits until `speak` has returned when it is running.
  ~ShutdownHook();
  ShutdownHook(const ShutdownHook&) = delete;
  ShutdownHook& operator=(const ShutdownHook&) = delete;

 private:
  class Listener;
  std::shared_ptr<Listener> listener_;
  std::function<void()> speak_;
};

/// To the log; once that has ended with ROS, to stderr. Written out, for a signal ends the process
/// without that.
/// @param name  of the node's logger
void sayAtTheEnd(const std::string& name, bool success, const std::string& text);

}  // namespace bearing_calibration_ros
