#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/StartDrive.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/drive_params.h"
#include "bearing_calibration_ros/drive_publisher.h"
#include "bearing_calibration_ros/drive_wheels.h"
#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/safety_input.h"
#include "bearing_calibration_ros/shutdown_hook.h"

namespace bearing_calibration_ros {

using core::DriveEnd;

/// Drives the robot so that its calibration learns fast: wheel readings, bearings and the estimate
/// in, cmd_vel out. It speaks on cmd_vel only while a drive is under way (action ~drive, service
/// ~start), and its last word there is to stand. No goal ever waits: a new one takes the robot over
/// as it moves, brakes it, and is what every stop ends from then on.
///
/// Threading: everything hangs on a queue of its own, served by one thread of its own, so that no
/// callback of another nodelet delays a command; nothing is locked. The control loop goes by real
/// time, so that the robot is stopped even when ROS time stands still. An exception in any callback
/// ends the drive.
class CalibrationDriveNodelet : public GuardedNodelet {
 public:
  ~CalibrationDriveNodelet() override {
    shutdown_hook_.reset();
    if (spinner_) spinner_->stop();
    if (!driver_) return;
    end(DriveEnd::kShutDown);
    stand();  // at once: nobody is left to brake
    finish(resultFrom(*driver_, estimate_));
  }

 private:
  using Result = msg::CalibrationDriveResult;

  void start() override {
    node_handle_ = getNodeHandle();
    private_node_handle_ = getPrivateNodeHandle();
    node_handle_.setCallbackQueue(&queue_);
    private_node_handle_.setCallbackQueue(&queue_);
    config_ = readConfig<DriveNodeConfig>(ParamReader(private_node_handle_));
    wheels_.emplace(config_, [this](const core::WheelTravel& travel) {
      if (driver_) driver_->addTravel(travel, stampFromRos(ros::Time::now()));
    });
    advertise();
    safety_inputs_ = std::make_unique<SafetyInputs>(node_handle_, private_node_handle_, config_,
                                                    [this](DriveEnd reason) { end(reason); });
    shutdown_hook_ = std::make_unique<ShutdownHook>([this] { runShutdownHook(); });
    subscribe();
    spinner_ = std::make_unique<ros::AsyncSpinner>(1, &queue_);
    spinner_->start();
  }

  /// While the process still lives, the control loop brakes as for any other reason; but the last
  /// word is to stand.
  void runShutdownHook() {
    const ros::SteadyTime end = ros::SteadyTime::now() + config_.longestStop();
    safety_inputs_->shutDown();
    while (is_driving_ && ros::SteadyTime::now() < end) ros::WallDuration(0.01).sleep();
    commands_->close();
    if (is_driving_) stand();
  }

  void advertise() {
    publisher_ = std::make_unique<DrivePublisher>(private_node_handle_, config_.start_frame);
    commands_.emplace([publisher = node_handle_.advertise<geometry_msgs::Twist>("cmd_vel", 1)](
                          const geometry_msgs::Twist& twist) { publisher.publish(twist); });
    action_server_ = std::make_unique<DriveActionServer>(
        private_node_handle_,
        [this](const auto& goal) { guarded("goal", [&] { onActionGoal(goal); }); },
        [this] { end(DriveEnd::kCancelled); });
    start_service_ =
        private_node_handle_.advertiseService("start", &CalibrationDriveNodelet::onStart, this);
    stop_service_ =
        private_node_handle_.advertiseService("stop", &CalibrationDriveNodelet::onStop, this);
  }

  void subscribe() {
    constexpr std::uint32_t kWheelQueue = 200;  // 2 s at 100 Hz
    constexpr std::uint32_t kQueue = 10;
    const auto hints = ros::TransportHints().tcpNoDelay();
    wheel_subscribers_ =
        subscribeToWheels(node_handle_, config_.wheels.source, kWheelQueue, wheelHandlers());
    bearing_subscriber_ = node_handle_.subscribe("bearings", kQueue,
                                                 &CalibrationDriveNodelet::onBearings, this, hints);
    estimate_subscriber_ = node_handle_.subscribe(
        "estimate", kQueue, &CalibrationDriveNodelet::onEstimate, this, hints);
    for (const auto& [name, timeout_s] : {std::pair("enable", config_.enable_timeout_s),
                                          std::pair("obstacle", config_.obstacle_timeout_s)}) {
      if (timeout_s > 0.0) continue;
      NODELET_WARN("timeouts/%s is 0: the robot drives on when the publisher of %s dies", name,
                   name);
    }
    timer_ = node_handle_.createWallTimer(ros::WallDuration(1.0 / config_.control_rate_hz),
                                          &CalibrationDriveNodelet::onControl, this);
  }

  WheelHandlers wheelHandlers() {
    const auto add = [this](const auto&... reading) {  // anew in a drive: TICKS_LOST
      if (wheels_->add(reading...) && !driver_) restartWheels("the wheels' stamps have");
    };
    return {[=](const msg::WheelTicksConstPtr& message) {
              guarded("wheels", [&] { add(countsFromMessage(*message)); });
            },
            [=](const sensor_msgs::JointStateConstPtr& message) {
              const auto angles = anglesFromMessage(*message, config_.wheels.joints);
              if (angles) guarded("wheels", [&] { add(*angles); });
            },
            [=](core::WheelSide side, const WheelCountEvent& event) {
              guarded("separate ticks", [&] {
                add(side, countFromMessage(*event.getMessage(), event.getReceiptTime()));
              });
            },
            [=](const nav_msgs::OdometryConstPtr& message) {
              guarded("wheels", [&] { add(odometryFromMessage(*message)); });
            }};
  }

  void restartWheels(const char* what) {
    if (throttle_.isDue(what)) NODELET_WARN("%s begun anew: the wheels are followed anew", what);
    wheels_->restart();
  }

  void onBearings(const msg::LightBearingsConstPtr& message) {
    guarded("bearings", [&] {
      const core::Stamp now = stampFromRos(ros::Time::now());
      if (driver_) driver_->addBearings(bearingsFromMessage(*message), now);
    });
  }

  void onEstimate(const msg::CalibrationEstimateConstPtr& message) {
    guarded("estimate", [&] {
      estimate_ = *message;
      const core::Stamp now = stampFromRos(ros::Time::now());
      if (driver_) driver_->addEstimate(driveEstimateFrom(*message), now);
    });
  }

  /// A goal replaces the drive before it at once. If it is refused, the robot stops all the same:
  /// who sent it meant another drive than the one under way.
  void onActionGoal(const DriveActionServer::Goal& handle) {
    end(DriveEnd::kCancelled);
    if (driver_) action_server_->finish(resultFrom(*driver_, estimate_));
    action_server_->accept(handle);
    const auto goal = handle.getGoal();
    const std::string error = begin(goal->motion, goal->max_time_s, goal->max_path_m);
    if (!error.empty()) action_server_->refuse(error, estimate_);
  }

  bool onStart(msg::StartDrive::Request& request, msg::StartDrive::Response& response) {
    response.message = driver_ ? "a drive is under way: ~stop ends it"
                               : begin(request.motion, request.max_time_s, request.max_path_m);
    response.success = response.message.empty();
    if (response.success) response.message = "the drive begins; ~stop ends it";
    return true;
  }

  bool onStop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    response.success = true;
    response.message = driver_ ? "the robot stops" : "there was no drive";
    end(DriveEnd::kCancelled);
    return true;
  }

  /// @returns why it cannot; empty when the drive begins.
  std::string begin(const std::string& motion, double max_time_s, double max_path_m) {
    // Whoever starts all nodes at once is ahead of /clock.
    ros::Time::waitForValid(ros::WallDuration(config_.clock_timeout_s));
    const ros::Time now = ros::Time::now();
    seeClock(now);  // a jump before the drive is none in it
    const DriveEnd objected = safety_inputs_->objection();
    std::string error = objected != DriveEnd::kNone ? core::describe(objected) : "";
    if (error.empty() && now.isZero()) error = "/clock has not begun (use_sim_time is set)";
    if (error.empty()) {
      error = thrownBy([&] {
        const core::DriveGoal goal = goalFrom(motion, max_time_s, max_path_m, config_.default_goal);
        const core::WheelSpeeds moving = driver_ ? driver_->command() : core::WheelSpeeds();
        driver_ = core::CalibrationDriver(config_.drive, goal, stampFromRos(now), moving);
        is_driving_ = true;
        publisher_->restart();
        NODELET_INFO("drive '%s' begins: at most %.0f s and %.0f m",
                     core::motionNames().at(static_cast<std::size_t>(goal.motion)).c_str(),
                     goal.max_time_s, goal.max_path_m);
      });
    }
    if (!error.empty()) NODELET_WARN("no drive: %s", error.c_str());
    return error;
  }

  /// The first reason stays; kNone is none.
  void end(DriveEnd reason) {
    if (driver_) driver_->end(reason);
  }

  void onControl(const ros::WallTimerEvent&) {
    guarded("control", [this] {
      safety_inputs_->seePublishers();
      const ros::Time now = ros::Time::now();
      if (!seeClock(now)) end(DriveEnd::kClockLost);
      if (driver_) steer(now);
    });
  }

  void steer(const ros::Time& now) {
    end(safety_inputs_->objection());
    const ros::SteadyTime last = std::exchange(last_control_, ros::SteadyTime::now());
    const core::WheelSpeeds speeds =
        driver_->steer(stampFromRos(now), (last_control_ - last).toSec());
    const bool is_at_once = driver_->ended() == DriveEnd::kClockLost || commands_->isClosed();
    if (is_at_once || (driver_->ended() != DriveEnd::kNone && driver_->standing())) {
      stand();
      publisher_->publish(*driver_, estimate_.header.frame_id, now);
      finish(resultFrom(*driver_, estimate_));
      return;
    }
    commands_->pass(twistFrom(speeds, config_.drive.limits.wheel_separation_m));
    constexpr int kControlsPerReport = 4;
    if (++controls_ % kControlsPerReport != 0) return;
    publisher_->publish(*driver_, estimate_.header.frame_id, now);
    action_server_->report(feedbackFrom(*driver_, estimate_));
  }

  /// @returns whether ROS time goes on; where it has begun anew, so have the readings' stamps.
  bool seeClock(const ros::Time& now) {
    const ros::SteadyTime steady_now = ros::SteadyTime::now();
    if (std::exchange(last_time_, now) != now) last_time_moved_ = steady_now;
    const bool has_jumped = clock_watch_.hasJumpedBack(now, config_.drive.timeouts.ticks_s);
    if (has_jumped) restartWheels("the clock has");
    return !has_jumped && (steady_now - last_time_moved_).toSec() <= config_.clock_timeout_s;
  }

  void stand() { commands_->pass(geometry_msgs::Twist()); }

  void finish(const Result& result) {
    driver_.reset();
    is_driving_ = false;
    say(result.end == Result::CONVERGED,
        core::formatted("the drive ended after %.1f s and %.2f m: ", result.time_s, result.path_m) +
            result.end_text);
    action_server_->finish(result);
  }

  /// After an error nothing is known of the drive any more: the robot stands at once.
  void onError(const std::string& callback, const std::string& error) override {
    GuardedNodelet::onError(callback, error);
    if (!driver_) return;
    stand();
    Result result = resultFrom(*driver_, estimate_);
    result.end = Result::FAILED;
    result.end_text = textOf(DriveEnd::kFailed) + ": " + callback + ": " + error;
    finish(result);
  }

  DriveNodeConfig config_;
  std::optional<DriveWheels> wheels_;
  std::optional<core::CalibrationDriver> driver_;  ///< until the robot stands
  std::atomic<bool> is_driving_{false};  ///< there is a driver_: for the thread of the last words
  msg::CalibrationEstimate estimate_ = noEstimate();  ///< the last one
  ClockWatch clock_watch_;
  ros::Time last_time_;
  ros::SteadyTime last_time_moved_, last_control_;
  int controls_ = 0;

  ros::CallbackQueue queue_;
  ros::NodeHandle node_handle_, private_node_handle_;  ///< on that queue
  std::unique_ptr<DrivePublisher> publisher_;
  std::unique_ptr<DriveActionServer> action_server_;
  std::optional<CommandGate> commands_;  ///< also of the thread of the last words
  ros::ServiceServer start_service_, stop_service_;
  std::vector<ros::Subscriber> wheel_subscribers_;
  ros::Subscriber bearing_subscriber_, estimate_subscriber_;
  std::unique_ptr<SafetyInputs> safety_inputs_;
  ros::WallTimer timer_;
  std::unique_ptr<ShutdownHook> shutdown_hook_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};

}  // namespace bearing_calibration_ros

PLUGINLIB_EXPORT_CLASS(bearing_calibration_ros::CalibrationDriveNodelet, nodelet::Nodelet)
