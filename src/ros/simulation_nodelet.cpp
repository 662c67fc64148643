#include <bearing_calibration/WheelTicks.h>
#include <geometry_msgs/Twist.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <thread>
#include <utility>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/simulated_camera.h"
#include "bearing_calibration_ros/simulation_params.h"
#include "bearing_calibration_ros/truth_publisher.h"

namespace bearing_calibration_ros {

/// Makes the simulation's steps happen in time: in wall time, or in a time of its own that is sent
/// to /clock and runs faster or slower. One thread waits; stop() may be called from another.
class SimulatedClock {
 public:
  SimulatedClock(ros::NodeHandle node_handle, const SimulatedClockConfig& config)
      : config_(config), wall_start_(WallClock::now()) {
    constexpr double kSimulatedStart_s = 1.0;  // zero means "no time yet" in ROS
    constexpr std::uint32_t kClockQueue = 10;  // whoever falls behind needs the newest alone
    start_ =
        config.publish ? core::stampFromSeconds(kSimulatedStart_s) : stampFromRos(ros::Time::now());
    if (config.publish) {
      publisher_ = node_handle.advertise<rosgraph_msgs::Clock>("/clock", kClockQueue);
    }
  }

  /// Stamp of the simulation's beginning.
  core::Stamp start() const { return start_; }

  /// Waits until it is `stamp` and sends it to /clock, if that is wanted. False when stopped.
  bool waitUntil(core::Stamp stamp) {
    const double rate = config_.publish ? config_.rate : 1.0;
    const double wall_s = core::secondsFromDuration(stamp - start_) / rate;
    const auto due = wall_start_ + core::durationFromSeconds(wall_s);
    std::unique_lock<std::mutex> lock(mutex_);
    if (stopped_.wait_until(lock, due, [this] { return is_stopped_; })) return false;
    if (config_.publish) {
      rosgraph_msgs::Clock message;
      message.clock = rosFromStamp(stamp);
      publisher_.publish(message);
      // Time lost to a busy machine stays lost: a simulated time need not catch up.
      wall_start_ += std::max(WallClock::now() - due, WallClock::duration::zero());
    }
    return true;
  }

  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
    stopped_.notify_all();
  }

 private:
  using WallClock = std::chrono::steady_clock;

  SimulatedClockConfig config_;
  core::Stamp start_;
  WallClock::time_point wall_start_;
  ros::Publisher publisher_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool is_stopped_ = false;  ///< under mutex_
};

/// A robot with wheel encoders and a camera under a conic mirror, near a light.
///
/// Threading: one thread moves the robot and publishes everything but images; the camera renders on
/// its own (see SimulatedCamera); cmd_vel comes on the nodelet's queue and leaves its command under
/// a lock for the first of them.
class SimulationNodelet : public GuardedNodelet {
 public:
  ~SimulationNodelet() override {
    endCallbacks();
    if (clock_) clock_->stop();
    if (camera_) camera_->stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void start() override {
    config_ = readConfig<SimulationNodeConfig>(ParamReader(getPrivateNodeHandle()));
    ros::NodeHandle& node_handle = getNodeHandle();
    clock_ = std::make_unique<SimulatedClock>(node_handle, config_.clock);
    startRobot(config_.robot, config_.driving);
    truth_ = std::make_unique<TruthPublisher>(getPrivateNodeHandle(), config_, clock_->start());
    const auto log_error = [this](const std::string& error) {
      NODELET_ERROR_THROTTLE(kWarningPeriod_s, "camera: %s", error.c_str());
    };
    const core::Scene scene = core::drawScene(config_.scene, config_.seed);
    config_.renderer.holders = scene.holders;
    camera_ = std::make_unique<SimulatedCamera>(node_handle, config_.frames.sensor,
                                                config_.renderer, scene, log_error);
    constexpr std::uint32_t kTicksQueue = 1000;  // ten seconds: the calibration needs every reading
    ticks_publisher_ = node_handle.advertise<msg::WheelTicks>("wheel_ticks", kTicksQueue);
    if (commanded_) {
      command_subscriber_ =
          node_handle.subscribe("cmd_vel", 1, &SimulationNodelet::onCommand, this);
    }
    thread_ = std::thread(&SimulationNodelet::run, this);
  }

  void startRobot(core::RobotConfig config, const DrivingConfig& driving) {
    const core::DriveGeometry& drive = config.encoders.drive;
    config.start = clock_->start();
    core::Trajectory trajectory;
    if (driving.follows_commands) {
      commanded_.emplace(drive.wheel_separation_m, drive.max_wheel_speed_mps,
                         driving.command_timeout_s);
      trajectory = [this](double step_s) { return commanded_->advance(step_s); };
    } else {
      trajectory = core::makeTrajectory(driving.trajectory, drive.wheel_separation_m);
    }
    if (driving.duration_s > 0.0) {
      trajectory = core::limitedTrajectory(std::move(trajectory), driving.duration_s);
    }
    simulator_ =
        std::make_unique<core::RobotSimulator>(config, config_.scene.lights, std::move(trajectory));
  }

  void onCommand(const geometry_msgs::TwistConstPtr& message) {
    guarded("cmd_vel", [&] {
      if (!std::isfinite(message->linear.x) || !std::isfinite(message->angular.z)) {
        NODELET_WARN_THROTTLE(
            kWarningPeriod_s, "%s: velocity (%f m/s, %f rad/s) is not finite: command ignored",
            command_subscriber_.getTopic().c_str(), message->linear.x, message->angular.z);
        return;
      }
      const std::lock_guard<std::mutex> lock(command_mutex_);
      command_ = *message;
    });
  }

  void run() {
    const std::string error = thrownBy([this] {
      while (!isOver() && clock_->waitUntil(simulator_->now())) {
        publishTicks();
        deliverImages();
        followCommand();
        photographWhileStepping();
      }
      if (!isOver()) return;
      deliverImages();  // the last one
      NODELET_INFO("end of the trajectory");
    });
    if (!error.empty()) NODELET_FATAL("the simulation ended: %s", error.c_str());
  }

  bool isOver() const {
    return config_.driving.stops_at_end && simulator_->timeSeconds() > config_.driving.duration_s;
  }

  void followCommand() {
    const std::lock_guard<std::mutex> lock(command_mutex_);
    if (!command_) return;
    commanded_->command(command_->linear.x, command_->angular.z);
    command_.reset();
  }

  void publishTicks() {
    const auto counts = simulator_->readTicks();
    if (!counts) return;
    msg::WheelTicks message;
    message.header.stamp = rosFromStamp(counts->stamp);
    message.left = counts->left_ticks;
    message.right = counts->right_ticks;
    ticks_publisher_.publish(message);
  }

  void photographWhileStepping() {
    const bool is_due = simulator_->bearingsDue();
    const core::Pose2 world_from_start = simulator_->worldFromSensor();
    if (is_due) {
      truth_->publish(*simulator_);
      const core::Stamp stamp =
          simulator_->now() + core::durationFromSeconds(config_.robot.stamp_latency_s);
      exposed_.push_back({stamp, image_count_++, {}, simulator_->lightsOccluded()});
    }
    simulator_->step();
    if (!is_due) return;
    // An exposure that lasts longer than the step goes on with its motion.
    exposed_.back().motion =
        core::motionBetween(world_from_start, simulator_->worldFromSensor(), config_.robot.step_s);
  }

  /// Of the steps before: an image is there once its rows are exposed.
  void deliverImages() {
    // A time of the simulation's own waits for the renderer; wall time does not.
    const auto when_busy =
        config_.clock.publish ? SimulatedCamera::WhenBusy::kWait : SimulatedCamera::WhenBusy::kDrop;
    while (!exposed_.empty() && exposed_.front().stamp <= simulator_->now()) {
      if (!camera_->take(exposed_.front(), when_busy)) {
        NODELET_WARN_THROTTLE(kWarningPeriod_s,
                              "camera/image_raw: the renderer cannot follow: image dropped");
      }
      exposed_.pop_front();
    }
  }

  SimulationNodeConfig config_;
  std::unique_ptr<SimulatedClock> clock_;
  std::unique_ptr<core::RobotSimulator> simulator_;
  std::optional<core::CommandedTrajectory> commanded_;  ///< the simulator's, when it is such a one
  std::unique_ptr<TruthPublisher> truth_;
  std::unique_ptr<SimulatedCamera> camera_;
  ros::Publisher ticks_publisher_;
  ros::Subscriber command_subscriber_;
  std::deque<Shot> exposed_;  ///< images whose stamp is still to come: the camera is late
  std::uint64_t image_count_ = 0;

  std::mutex command_mutex_;
  std::optional<geometry_msgs::Twist> command_;  ///< under command_mutex_
  std::thread thread_;
};

}  // namespace bearing_calibration_ros

PLUGINLIB_EXPORT_CLASS(bearing_calibration_ros::SimulationNodelet, nodelet::Nodelet)
