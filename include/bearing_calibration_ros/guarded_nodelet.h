#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/detail/callback_queue.h>
#include <nodelet/nodelet.h>
#include <ros/node_handle.h>
#include <ros/time.h>

#include <boost/function.hpp>
#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

#include "bearing_calibration_ros/sensor_places.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

/// Lets a message of each kind through once in a while. Unlike the *_THROTTLE macros it knows kinds
/// apart, so that one fault does not hide another, and it goes by a clock that always runs: with
/// simulated time those say nothing before /clock begins.
class LogThrottle {
 public:
  explicit LogThrottle(double period_s) : period_(period_s) {}

  bool isDue(const std::string& kind, ros::SteadyTime now = ros::SteadyTime::now()) {
    const auto [last, is_first] = last_.try_emplace(kind, now);
    if (!is_first && now - last->second < period_) return false;
    last->second = now;
    return true;
  }
  void restart() { last_.clear(); }

 private:
  ros::WallDuration period_;
  std::map<std::string, ros::SteadyTime> last_;
};

/// What has come and what was refused since the start, by its name in the diagnostics.
using Counts = std::map<std::string, std::uint64_t>;

/// What the nodelets share: one that cannot start says why, and an exception
/// ends at its callback, so that the manager and its other nodelets live on.
///
/// Threading: a manager that ends deletes its nodelets while its threads still call them. So each
/// destructor of a nodelet with callbacks on getNodeHandle()'s queue begins with endCallbacks().
class GuardedNodelet : public nodelet::Nodelet {
 protected:
  static constexpr double kWarningPeriod_s = 5.0;  ///< readable, and no fault goes unnoticed long

  /// Sets everything up. Whatever it throws is said, and the nodelet is not loaded.
  virtual void start() = 0;
  /// Is told what a callback has thrown.
  virtual void onError(const std::string& callback, const std::string& error) {
    if (throttle_.isDue(callback)) NODELET_ERROR("%s: %s", callback.c_str(), error.c_str());
  }

  /// Does the work of a callback. @returns what it threw, in words; empty when all went well
  template <typename Work>
  std::string guarded(const std::string& callback, Work work) {
    const std::lock_guard<std::timed_mutex> lock(callback_mutex_);
    if (has_ended_) return "the node ends";
    const std::string error = thrownBy(work);
    if (!error.empty()) onError(callback, error);
    return error;
  }

  /// Waits for the callback that runs; no other one begins.
  void endCallbacks() {
    if (queue_ != nullptr) queue_->disable();
    const std::lock_guard<std::timed_mutex> lock(callback_mutex_);
    has_ended_ = true;
  }

  void say(bool is_good, const std::string& sentence) {
    if (is_good) {
      NODELET_INFO("%s", sentence.c_str());
    } else {
      NODELET_WARN("%s", sentence.c_str());
    }
  }
  /// Says that messages are of another frame than the parameter's, which they are taken for.
  void checkFrame(const std::string& topic, const std::string& frame, const std::string& parameter,
                  const std::string& expected) {
    const bool is_it = frame.empty() || areOneFrame(frame, expected);
    if (is_it || !throttle_.isDue(parameter)) return;
    NODELET_WARN("%s: frame '%s' is not %s '%s': taken as if it were", topic.c_str(), frame.c_str(),
                 parameter.c_str(), expected.c_str());
  }

  /// Lets `take` have each message of a topic, as a guarded callback.
  template <class Message, class Take>
  ros::Subscriber listenTo(const std::string& topic, std::uint32_t queue, Take take) {
    const boost::function<void(const boost::shared_ptr<const Message>&)> callback =
        [this, topic, take](const boost::shared_ptr<const Message>& message) {
          guarded(topic, [&] { take(message); });
        };
    return getNodeHandle().subscribe<Message>(topic, queue, callback, {},
                                              ros::TransportHints().tcpNoDelay());
  }

  /// Diagnostics with one status, which `fill` fills in once a second, after `work`.
  void startDiagnostics(
      const std::string& name, const diagnostic_updater::TaskFunction& fill,
      const std::function<void()>& work = [] {}) {
    diagnostics_ = std::make_unique<diagnostic_updater::Updater>(getNodeHandle(),
                                                                 getPrivateNodeHandle(), getName());
    diagnostics_->setHardwareID("none");
    diagnostics_->add(name, fill);
    timer_ = getNodeHandle().createWallTimer(ros::WallDuration(1.0), [this, work](const auto&) {
      guarded("timer", work);
      guarded("diagnostics", [this] { diagnostics_->force_update(); });
    });
  }

  LogThrottle throttle_{kWarningPeriod_s};
  std::timed_mutex callback_mutex_;  ///< held by the callback that runs

 private:
  void onInit() final {
    auto* queue = dynamic_cast<nodelet::detail::CallbackQueue*>(getNodeHandle().getCallbackQueue());
    if (queue != nullptr) queue_ = queue->shared_from_this();
    const std::string error = thrownBy([this] { start(); });
    if (error.empty()) return;
    NODELET_FATAL("not started: %s", error.c_str());
    endCallbacks();                   // some may be there already
    throw std::runtime_error(error);  // tells the nodelet loader, which says nothing by itself
  }

  /// The manager's. A loader lets go of the queue of a nodelet that has not started before it
  /// deletes the nodelet, whose subscribers still need it: it is held until they are gone.
  boost::shared_ptr<nodelet::detail::CallbackQueue> queue_;
  bool has_ended_ = false;  ///< under callback_mutex_
  std::unique_ptr<diagnostic_updater::Updater> diagnostics_;
  ros::WallTimer timer_;
};

}  // namespace bearing_calibration_ros
