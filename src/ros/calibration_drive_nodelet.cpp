#include <actionlib/server/simple_action_server.h>
#include <bearing_calibration/CalibrationDriveAction.h>
#include <bearing_calibration/CalibrationEstimate.h>
#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/StartDrive.h>
#include <geometry_msgs/Twist.h>
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <std_msgs/Bool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <thread>
#include <vector>

#include "bearing_calibration/odometry/wheel_odometer.h"
#include "bearing_calibration/odometry/wheel_pairing.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/drive_params.h"
#include "bearing_calibration_ros/drive_publisher.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/log_throttle.h"
#include "bearing_calibration_ros/safety_input.h"
#include "bearing_calibration_ros/shutdown_hook.h"
#include "bearing_calibration_ros/thrown.h"
#include "bearing_calibration_ros/tick_message.h"
#include "bearing_calibration_ros/wheel_subscription.h"

namespace bearing_calibration_ros {

/// Drives the robot so that its calibration learns fast: wheel readings, bearings and the estimate
/// in, cmd_vel out. It speaks on cmd_vel only while a drive is under way (action ~drive, service
/// ~start), and its last word there is to stand. No goal ever waits: a new one takes the robot over
/// as it moves, brakes it, and is what every stop ends from then on.
///
/// Threading: everything hangs on a queue of its own, served by one thread of its own, so that no
/// callback of another nodelet delays a command; nothing is locked. The control loop goes by real
/// time, so that the robot is stopped even when ROS time stands still. An exception in any callback
/// ends the drive.
class CalibrationDriveNodelet : public nodelet::Nodelet {
 public:
  ~CalibrationDriveNodelet() override;

 private:
  using ActionServer = actionlib::SimpleActionServer<msg::CalibrationDriveAction>;

  void onInit() override;
  void makeSafetyInputs();
  void advertise();
  void subscribe();

  void onTicks(const msg::WheelTicksConstPtr& message);
  void onJointStates(const sensor_msgs::JointStateConstPtr& message);
  void onWheel(core::WheelSide side, const WheelCountEvent& event);
  void onBearings(const msg::LightBearingsConstPtr& message);
  void onEstimate(const msg::CalibrationEstimateConstPtr& message);
  void onObstacle(const std_msgs::BoolConstPtr& message);
  void onEnable(const std_msgs::BoolConstPtr& message);
  void onActionGoal();
  void onActionCancel() { end(core::DriveEnd::kCancelled); }
  bool onStart(msg::StartDrive::Request& request, msg::StartDrive::Response& response);
  bool onStop(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void onControl(const ros::WallTimerEvent& event);

  void addTravel(const core::InputOutcome& outcome);
  std::string begin(const std::string& motion, double max_time_s, double max_path_m);
  core::DriveEnd objection() const;
  void end(core::DriveEnd reason);
  void steer();
  bool timeStandsStill(const ros::Time& now);
  void finish(const msg::CalibrationDriveResult& result);
  void fail(const char* callback, const std::string& error);
  void reportActionEnd(const msg::CalibrationDriveResult& result);
  void runShutdownHook();
  void stand() { command_publisher_.publish(geometry_msgs::Twist()); }

  template <typename Work>
  void guarded(const char* callback, Work work) {
    const std::string error = thrownBy(work);
    if (!error.empty()) fail(callback, error);
  }

  DriveNodeConfig config_;
  std::optional<core::WheelPairing> pairing_;  ///< of separate ticks
  std::optional<core::WheelOdometer> odometer_;
  std::optional<core::CalibrationDriver> driver_;  ///< until the robot stands
  // Between the callbacks and the thread of the last words:
  std::atomic<bool> is_driving_{false};    ///< there is a driver_
  std::atomic<bool> is_shut_down_{false};  ///< no drive any more
  msg::CalibrationEstimate estimate_;      ///< the last one
  std::optional<SafetyInput> enable_input_, obstacle_input_;
  ClockWatch clock_watch_;
  ros::Time last_time_;
  ros::SteadyTime last_time_moved_;
  int controls_ = 0;

  ros::CallbackQueue queue_;
  ros::NodeHandle node_handle_, private_node_handle_;  ///< on that queue
  std::unique_ptr<DrivePublisher> publisher_;
  std::unique_ptr<ActionServer> action_server_;
  ros::Publisher command_publisher_;
  ros::ServiceServer start_service_, stop_service_;
  std::vector<ros::Subscriber> wheel_subscribers_;
  ros::Subscriber bearing_subscriber_, estimate_subscriber_;
  ros::Subscriber obstacle_subscriber_, enable_subscriber_;
  ros::WallTimer timer_;
  LogThrottle throttle_{kWarningPeriod_s};
  std::unique_ptr<ShutdownHook> shutdown_hook_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;

  static constexpr double kWarningPeriod_s = 5.0;
};

CalibrationDriveNodelet::~CalibrationDriveNodelet() {
  shutdown_hook_.reset();
  if (spinner_) spinner_->stop();
  if (driver_) stand();  // at once: nobody is left to brake
  is_driving_ = false;
}

/// While the process still lives, the control loop brakes as for any other reason.
void CalibrationDriveNodelet::runShutdownHook() {
  constexpr int kWaits = 100;
  constexpr std::chrono::milliseconds kWait{10};
  is_shut_down_ = true;
  for (int i = 0; i < kWaits && is_driving_; ++i) std::this_thread::sleep_for(kWait);
  if (is_driving_) stand();  // the control loop is stuck
}

void CalibrationDriveNodelet::onInit() {
  try {
    node_handle_ = getNodeHandle();
    private_node_handle_ = getPrivateNodeHandle();
    node_handle_.setCallbackQueue(&queue_);
    private_node_handle_.setCallbackQueue(&queue_);
    config_ = readConfig<DriveNodeConfig>(ParamReader(private_node_handle_));
    makeSafetyInputs();
    pairing_.emplace(config_.geometry.counter_bits, config_.wheel_times.max_apart_s);
    odometer_.emplace(config_.geometry);
    advertise();
    shutdown_hook_ = std::make_unique<ShutdownHook>([this] { runShutdownHook(); });
    subscribe();
    spinner_ = std::make_unique<ros::AsyncSpinner>(1, &queue_);
    spinner_->start();
  } catch (const std::exception& error) {
    NODELET_FATAL("not started: %s", error.what());
    throw;  // tells the nodelet loader, which says nothing by itself
  }
}

void CalibrationDriveNodelet::makeSafetyInputs() {
  using core::DriveEnd;
  enable_input_.emplace(SafetyInput::Ends{DriveEnd::kDisabled, DriveEnd::kEnableLost},
                        config_.enable_timeout_s, config_.enable_required);
  obstacle_input_.emplace(SafetyInput::Ends{DriveEnd::kObstacle, DriveEnd::kObstacleLost},
                          config_.obstacle_timeout_s, false);
  for (const auto& [name, timeout_s] : {std::pair("enable", config_.enable_timeout_s),
                                        std::pair("obstacle", config_.obstacle_timeout_s)}) {
    if (timeout_s > 0.0) continue;
    NODELET_WARN("timeouts/%s is 0: the robot drives on when the publisher of %s dies", name, name);
  }
}

void CalibrationDriveNodelet::advertise() {
  publisher_ = std::make_unique<DrivePublisher>(private_node_handle_, config_.start_frame);
  command_publisher_ = node_handle_.advertise<geometry_msgs::Twist>("cmd_vel", 1);
  constexpr bool kLater = false;
  action_server_ = std::make_unique<ActionServer>(private_node_handle_, "drive", kLater);
  action_server_->registerGoalCallback([this] { guarded("goal", [this] { onActionGoal(); }); });
  action_server_->registerPreemptCallback([this] { onActionCancel(); });
  action_server_->start();
  start_service_ =
      private_node_handle_.advertiseService("start", &CalibrationDriveNodelet::onStart, this);
  stop_service_ =
      private_node_handle_.advertiseService("stop", &CalibrationDriveNodelet::onStop, this);
}

void CalibrationDriveNodelet::subscribe() {
  constexpr std::uint32_t kWheelQueue = 200;  // 2 s at 100 Hz
  constexpr std::uint32_t kQueue = 10;
  const auto hints = ros::TransportHints().tcpNoDelay();
  wheel_subscribers_ = subscribeToWheels(
      node_handle_, config_.wheels.source, kWheelQueue,
      {[this](const msg::WheelTicksConstPtr& message) { onTicks(message); },
       [this](const sensor_msgs::JointStateConstPtr& message) { onJointStates(message); },
       [this](core::WheelSide side, const WheelCountEvent& event) { onWheel(side, event); }});
  bearing_subscriber_ =
      node_handle_.subscribe("bearings", kQueue, &CalibrationDriveNodelet::onBearings, this, hints);
  estimate_subscriber_ =
      node_handle_.subscribe("estimate", kQueue, &CalibrationDriveNodelet::onEstimate, this, hints);
  obstacle_subscriber_ =
      node_handle_.subscribe("obstacle", kQueue, &CalibrationDriveNodelet::onObstacle, this, hints);
  enable_subscriber_ = private_node_handle_.subscribe(
      "enable", kQueue, &CalibrationDriveNodelet::onEnable, this, hints);
  timer_ = node_handle_.createWallTimer(ros::WallDuration(1.0 / config_.control_rate_hz),
                                        &CalibrationDriveNodelet::onControl, this);
}

void CalibrationDriveNodelet::onTicks(const msg::WheelTicksConstPtr& message) {
  guarded("wheel ticks", [&] { addTravel(odometer_->add(countsFromMessage(*message))); });
}

void CalibrationDriveNodelet::onJointStates(const sensor_msgs::JointStateConstPtr& message) {
  guarded("joint states", [&] {
    const auto angles = anglesFromMessage(*message, config_.wheels.joints);
    if (angles) addTravel(odometer_->add(*angles));
  });
}

void CalibrationDriveNodelet::onWheel(core::WheelSide side, const WheelCountEvent& event) {
  guarded("separate ticks", [&] {
    const core::WheelCount count = countFromMessage(*event.getMessage(), event.getReceiptTime());
    for (const core::WheelCounts& pair : pairing_->add(side, count).pairs) {
      addTravel(odometer_->add(pair));
    }
  });
}

void CalibrationDriveNodelet::addTravel(const core::InputOutcome& outcome) {
  if (!outcome.accepted() || !driver_) return;  // bad readings are no readings: TICKS_LOST
  driver_->addTravel(*odometer_->travel(), stampFromRos(ros::Time::now()));
}

void CalibrationDriveNodelet::onBearings(const msg::LightBearingsConstPtr& message) {
  if (driver_ && !message->candidates.empty()) {
    driver_->noteBearing(stampFromRos(ros::Time::now()));
  }
}

void CalibrationDriveNodelet::onEstimate(const msg::CalibrationEstimateConstPtr& message) {
  guarded("estimate", [&] {
    estimate_ = *message;
    if (!driver_) return;
    driver_->addEstimate(
        {stampFromRos(message->header.stamp), static_cast<core::CalibrationState>(message->state),
         robotFromMessage(*message)},
        stampFromRos(ros::Time::now()));
  });
}

void CalibrationDriveNodelet::onObstacle(const std_msgs::BoolConstPtr& message) {
  obstacle_input_->hear(!message->data, ros::SteadyTime::now());
  if (message->data) end(core::DriveEnd::kObstacle);
}

void CalibrationDriveNodelet::onEnable(const std_msgs::BoolConstPtr& message) {
  enable_input_->hear(message->data, ros::SteadyTime::now());
  if (!message->data) end(core::DriveEnd::kDisabled);
}

/// A goal replaces the drive before it at once. If it is refused, the robot stops all the same: who
/// sent it meant another drive than the one under way.
void CalibrationDriveNodelet::onActionGoal() {
  end(core::DriveEnd::kCancelled);
  if (action_server_->isActive()) reportActionEnd(resultFrom(*driver_, estimate_));
  const msg::CalibrationDriveGoalConstPtr goal = action_server_->acceptNewGoal();
  const std::string error = begin(goal->motion, goal->max_time_s, goal->max_path_m);
  if (!error.empty()) action_server_->setAborted({}, error);
}

bool CalibrationDriveNodelet::onStart(msg::StartDrive::Request& request,
                                      msg::StartDrive::Response& response) {
  response.message = driver_ ? "a drive is under way: ~stop ends it"
                             : begin(request.motion, request.max_time_s, request.max_path_m);
  response.success = response.message.empty();
  if (response.success) response.message = "the drive begins; ~stop ends it";
  return true;
}

bool CalibrationDriveNodelet::onStop(std_srvs::Trigger::Request&,
                                     std_srvs::Trigger::Response& response) {
  response.success = true;
  response.message = driver_ ? "the robot stops" : "there was no drive";
  end(core::DriveEnd::kCancelled);
  return true;
}

/// @returns why it cannot; empty when the drive begins.
std::string CalibrationDriveNodelet::begin(const std::string& motion, double max_time_s,
                                           double max_path_m) {
  std::string error;
  const ros::WallDuration clock_patience(config_.clock_timeout_s);
  ros::Time::waitForValid(clock_patience);  // whoever starts all nodes at once is ahead of /clock
  const ros::Time now = ros::Time::now();
  if (now.isZero()) error = "/clock has not begun (use_sim_time is set)";
  const core::DriveEnd objected = objection();
  if (objected != core::DriveEnd::kNone) error = core::describe(objected);
  if (error.empty()) {
    try {
      const core::DriveGoal goal = goalFrom(motion, max_time_s, max_path_m, config_.default_goal);
      const core::WheelSpeeds moving = driver_ ? driver_->command() : core::WheelSpeeds();
      driver_ = core::CalibrationDriver(config_.drive, goal, stampFromRos(now), moving);
      is_driving_ = true;
      publisher_->restart();
      last_time_ = now;
      last_time_moved_ = ros::SteadyTime::now();
      NODELET_INFO("drive '%s' begins: at most %.0f s and %.0f m",
                   core::motionNames().at(static_cast<std::size_t>(goal.motion)).c_str(),
                   goal.max_time_s, goal.max_path_m);
    } catch (const std::exception& exception) {
      error = exception.what();
    }
  }
  if (!error.empty()) NODELET_WARN("no drive: %s", error.c_str());
  return error;
}

/// Why the robot must not drive now; kNone when it may.
core::DriveEnd CalibrationDriveNodelet::objection() const {
  if (is_shut_down_) return core::DriveEnd::kShutDown;
  const ros::SteadyTime now = ros::SteadyTime::now();
  const core::DriveEnd obstacle = obstacle_input_->objection(now);
  return obstacle != core::DriveEnd::kNone ? obstacle : enable_input_->objection(now);
}

void CalibrationDriveNodelet::end(core::DriveEnd reason) {
  if (driver_) driver_->end(reason);
}

void CalibrationDriveNodelet::onControl(const ros::WallTimerEvent&) {
  guarded("control", [this] {
    const ros::SteadyTime now = ros::SteadyTime::now();
    if (enable_subscriber_.getNumPublishers() > 0) enable_input_->seePublisher(now);
    if (obstacle_subscriber_.getNumPublishers() > 0) obstacle_input_->seePublisher(now);
    if (driver_) steer();
  });
}

void CalibrationDriveNodelet::steer() {
  const ros::Time now = ros::Time::now();
  if (timeStandsStill(now)) end(core::DriveEnd::kClockLost);
  const core::DriveEnd objected = objection();
  if (objected != core::DriveEnd::kNone) end(objected);
  const core::WheelSpeeds speeds = driver_->steer(stampFromRos(now));
  const bool is_without_time = driver_->ended() == core::DriveEnd::kClockLost;
  if (is_without_time || (driver_->ended() != core::DriveEnd::kNone && driver_->standing())) {
    stand();
    publisher_->publish(*driver_, estimate_.header.frame_id, now);
    finish(resultFrom(*driver_, estimate_));
    return;
  }
  command_publisher_.publish(twistFrom(speeds, config_.drive.limits.wheel_separation_m));
  constexpr int kControlsPerReport = 4;
  if (++controls_ % kControlsPerReport != 0) return;
  publisher_->publish(*driver_, estimate_.header.frame_id, now);
  if (action_server_->isActive())
    action_server_->publishFeedback(feedbackFrom(*driver_, estimate_));
}

bool CalibrationDriveNodelet::timeStandsStill(const ros::Time& now) {
  const ros::SteadyTime steady_now = ros::SteadyTime::now();
  if (now != last_time_) last_time_moved_ = steady_now;
  last_time_ = now;
  // Until the readings' stamps overtake the last one, the wheels are not heard.
  return clock_watch_.hasJumpedBack(now, config_.drive.timeouts.ticks_s) ||
         (steady_now - last_time_moved_).toSec() > config_.clock_timeout_s;
}

void CalibrationDriveNodelet::finish(const msg::CalibrationDriveResult& result) {
  driver_.reset();
  is_driving_ = false;
  const bool is_good = result.end == msg::CalibrationDriveResult::CONVERGED;
  if (is_good) {
    NODELET_INFO("the drive ended after %.1f s and %.2f m: %s", result.time_s, result.path_m,
                 result.end_text.c_str());
  } else {
    NODELET_WARN("the drive ended after %.1f s and %.2f m: %s", result.time_s, result.path_m,
                 result.end_text.c_str());
  }
  if (action_server_->isActive()) reportActionEnd(result);
}

/// After an error nothing is known of the drive any more: the robot stands at once.
void CalibrationDriveNodelet::fail(const char* callback, const std::string& error) {
  if (throttle_.isDue(callback)) NODELET_ERROR("%s: %s", callback, error.c_str());
  if (!driver_) return;
  stand();
  msg::CalibrationDriveResult result;
  result.end = msg::CalibrationDriveResult::FAILED;
  result.end_text =
      std::string("FAILED: an error inside of the drive node: ") + callback + ": " + error;
  finish(result);
}

void CalibrationDriveNodelet::reportActionEnd(const msg::CalibrationDriveResult& result) {
  if (result.end == msg::CalibrationDriveResult::CONVERGED) {
    action_server_->setSucceeded(result, result.end_text);
  } else if (result.end == msg::CalibrationDriveResult::CANCELLED) {
    action_server_->setPreempted(result, result.end_text);
  } else {
    action_server_->setAborted(result, result.end_text);
  }
}

}  // namespace bearing_calibration_ros

PLUGINLIB_EXPORT_CLASS(bearing_calibration_ros::CalibrationDriveNodelet, nodelet::Nodelet)
