#include <bearing_calibration/LightBearings.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/calibration_publisher.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/result_saver.h"
#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration_ros {

/// Wheel readings and bearings in, the mount of the sensor out.
///
/// Threading: every subscriber, timer and service hangs on getNodeHandle()'s queue, which a nodelet
/// manager serves with one thread at a time. So no callback runs beside another; callback_mutex_
/// only keeps out the threads that save and delete at the end. Fits run on a thread of the
/// calibrator's own, which touches nothing that a callback does (FitsBeside). That queue may be
/// served while start() is still under way: everything that a callback uses exists before the
/// first of them can come, and is not touched by start() afterwards.
class CalibrationNodelet : public GuardedNodelet {
 public:
  ~CalibrationNodelet() override { endCallbacks(); }

 private:
  void start() override {
    config_ =
        readCalibrationNodeConfig(ParamReader(getPrivateNodeHandle()), ResultFolder::kWritten);
    calibrator_ = std::make_unique<core::Calibrator>(config_.calibrator, core::FitsRun::kBeside);
    std::vector<std::string> wheel_topics = wheelTopics(config_.wheels.source);
    for (std::string& topic : wheel_topics) topic = getNodeHandle().resolveName(topic);
    wheel_topic_ = core::joined(wheel_topics, " with ");
    bearing_topic_ = getNodeHandle().resolveName("bearings");
    input_watch_ =
        std::make_unique<InputWatch>(wheel_topic_, bearing_topic_, config_.input_timeout_s);
    publisher_ =
        std::make_unique<CalibrationPublisher>(getPrivateNodeHandle(), config_, calibrator_.get());
    resumeFromSavedResult();
    publisher_->publishEstimate();
    saver_ = std::make_unique<ResultSaver>(  // with a timer: from here on callbacks may come
        getNodeHandle(), config_, getName(), wheel_topic_ + ", " + bearing_topic_,
        [this] { return calibrator_->result(); }, &callback_mutex_);
    subscribe();
  }

  void resumeFromSavedResult() {
    if (!config_.resume) return;
    const EarlierResult earlier = readEarlierResult(config_);
    if (earlier.lasting) calibrator_->resume(*earlier.lasting);
    say(earlier.lasting.has_value(), earlier.message);
  }

  void subscribe() {
    constexpr std::uint32_t kWheelQueue = 2000;   // 20 s at 100 Hz: a replay faster than the clock
    constexpr std::uint32_t kBearingQueue = 200;  // the same 20 s at 10 Hz
    ros::NodeHandle& node_handle = getNodeHandle();
    ros::NodeHandle& private_node_handle = getPrivateNodeHandle();
    reset_service_ =
        private_node_handle.advertiseService("reset", &CalibrationNodelet::onReset, this);
    pause_service_ =
        private_node_handle.advertiseService("pause", &CalibrationNodelet::onPause, this);
    save_service_ = private_node_handle.advertiseService("save", &CalibrationNodelet::onSave, this);
    wheel_subscribers_ =
        subscribeToWheels(node_handle, config_.wheels.source, kWheelQueue, wheelHandlers());
    bearing_subscriber_ =
        node_handle.subscribe("bearings", kBearingQueue, &CalibrationNodelet::onBearings, this,
                              ros::TransportHints().tcpNoDelay());
    startDiagnostics(
        "calibration", [this](auto& status) { diagnose(status); }, [this] { doEachSecond(); });
    if (!config_.output.publish_tf) return;
    constexpr double kTransformPeriod_s = 0.1;  // TF's listeners interpolate
    transform_timer_ =
        node_handle.createTimer(ros::Duration(kTransformPeriod_s), [this](const ros::TimerEvent&) {
          guarded("transform", [this] {
            if (const auto now = timeOfReceipt()) publisher_->sendTransform(*now);
          });
        });
  }

  /// A player sends its first messages before the first /clock: what comes early waits for it.
  template <class Input>
  void receive(const char* what, const Input& input) {
    guarded(what, [&] {
      const std::optional<ros::Time> now = timeOfReceipt();
      if (!now) {
        constexpr std::size_t kMostEarly = 2000;  // as many as the longest queue holds
        if (early_inputs_.size() == kMostEarly) early_inputs_.pop_front();
        early_inputs_.emplace_back(input);
        return;
      }
      for (const auto& early : std::exchange(early_inputs_, {})) {
        const std::string error = thrownBy([&] { early(*now); });
        if (!error.empty()) onError(what, error);
      }
      input(*now);
    });
  }

  WheelHandlers wheelHandlers() {
    return {[this](const msg::WheelTicksConstPtr& message) {
              receive("wheel ticks", [this, message](const ros::Time& now) {
                const core::WheelCounts counts = countsFromMessage(*message);
                finishWheels(calibrator_->addTicks(counts, stampFromRos(now)), counts.stamp, now);
              });
            },
            [this](const sensor_msgs::JointStateConstPtr& message) {
              receive("joint states",
                      [this, message](const ros::Time& now) { addJointState(*message, now); });
            },
            [this](core::WheelSide side, const WheelCountEvent& event) {
              receive(side == core::WheelSide::kLeft ? "left ticks" : "right ticks",
                      [this, side, event](const ros::Time& now) { addWheel(side, event, now); });
            },
            [this](const nav_msgs::OdometryConstPtr& message) {
              receive("odometry", [this, message](const ros::Time& now) {
                checkFrame(wheel_topic_, message->child_frame_id, "frames/base",
                           config_.frames.base);
                const core::OdometryPose pose = odometryFromMessage(*message);
                finishWheels(calibrator_->addOdometry(pose, stampFromRos(now)), pose.stamp, now);
              });
            }};
  }

  void addJointState(const sensor_msgs::JointState& message, const ros::Time& now) {
    const auto angles = anglesFromMessage(message, config_.wheels.joints);
    if (angles) {
      finishWheels(calibrator_->addAngles(*angles, stampFromRos(now)), angles->stamp, now);
      return;
    }
    // another publisher's, an arm's for instance
    if (!namesEither(message, config_.wheels.joints) && input_watch_->areWheelsAlive(now)) return;
    publisher_->countJointStateWithoutWheels();
    publisher_->offerEstimate();
    if (!throttle_.isDue("joints")) return;
    say(false, wheel_topic_ + ": " + describeMissing(config_.wheels.joints, message));
  }

  /// The stamps of the left wheel alone tell whether they have begun anew: both would take turns.
  void addWheel(core::WheelSide side, const WheelCountEvent& event, const ros::Time& now) {
    const core::WheelCount count = countFromMessage(*event.getMessage(), event.getReceiptTime());
    const bool is_of_no_clock = event.getReceiptTime().isZero() && count.stamp == core::Stamp();
    if (is_of_no_clock) return;  // without a stamp of its own, and /clock had not begun
    const core::InputOutcome outcome = calibrator_->addWheel(side, count, stampFromRos(now));
    if (side == core::WheelSide::kLeft) {
      finishWheels(outcome, count.stamp, now);
    } else {
      warn(wheel_topic_, outcome);
    }
  }

  void onBearings(const msg::LightBearingsConstPtr& message) {
    receive("bearings", [this, message](const ros::Time& now) {
      input_watch_->sawBearings(now);
      checkFrame(bearing_topic_, message->header.frame_id, "frames/sensor", config_.frames.sensor);
      warn(bearing_topic_,
           calibrator_->addBearings(bearingsFromMessage(*message), stampFromRos(now)));
      publisher_->offerEstimate();
    });
  }

  /// There may be no inputs any more.
  void doEachSecond() {
    const std::string error = thrownBy([&] { calibrator_->takeOverFit(); });
    if (!error.empty()) onError("fit", error);
    timeOfReceipt();  // a clock that jumped back
    publisher_->publishEstimate();
    publisher_->offerMarkers();
    saver_->check();
  }

  bool onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    return serve("reset", &response, [&] {
      response.message = "the calibration starts anew" + startAnew();
      if (calibrator_->isPaused()) response.message += "; it is paused as before";
      saver_->expectAnotherMount();
      response.success = true;
      NODELET_INFO("~reset was called: %s", response.message.c_str());
    });
  }

  bool onPause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
    return serve("pause", &response, [&] {
      saver_->check();
      calibrator_->setPaused(request.data);
      publisher_->publishEstimate();
      response.success = true;
      response.message = request.data ? "paused: bearings are ignored" : "bearings are fused again";
    });
  }

  bool onSave(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    return serve("save", &response, [&] {
      const core::StoredResult outcome = saver_->save();
      response.success = outcome.success;
      response.message = outcome.message;
    });
  }

  /// None while the clock is zero: simulated time has not begun.
  std::optional<ros::Time> timeOfReceipt() {
    const ros::Time now = ros::Time::now();
    if (now.isZero()) {
      if (throttle_.isDue("clock")) {
        NODELET_WARN("/clock has not begun (use_sim_time is set): inputs wait until then");
      }
      return std::nullopt;
    }
    if (clock_watch_.hasJumpedBack(now, config_.max_step_back_s)) followJumpBack("the clock has");
    return now;
  }

  /// @returns what became of what it had found, to end a sentence with
  std::string startAnew() {
    const std::string saved = saver_->saveBeforeReset();
    calibrator_->reset();
    publisher_->restart();
    stamp_watch_ = {};
    throttle_.restart();  // what was said of the old calibration is old, too
    input_watch_->restart();
    publisher_->publishEstimate();
    return saved.empty() ? "" : "; what it had found: " + saved;
  }

  void followJumpBack(const std::string& what) {
    publisher_->restartStamps();
    const std::string saved = startAnew();
    NODELET_WARN(
        "%s jumped back by more than clock/max_step_back (%g s): the calibration starts anew%s",
        what.c_str(), config_.max_step_back_s, saved.c_str());
  }

  void finishWheels(const core::InputOutcome& outcome, core::Stamp stamp, const ros::Time& now) {
    if (!input_watch_->areWheelsAlive(now)) publisher_->expectNews();
    input_watch_->sawWheels(now);
    warn(wheel_topic_, outcome);
    if (stamp_watch_.hasBegunAnew(outcome, stamp, config_.max_step_back_s)) {
      followJumpBack("the stamps on " + wheel_topic_ + " have");
    }
    publisher_->offerEstimate();
    if (!outcome.isBadInput()) publisher_->offerPrediction(stamp);
    publisher_->offerMarkers();
  }

  void warn(const std::string& topic, const core::InputOutcome& outcome) {
    if (!outcome.isWorthAWord()) return;
    publisher_->expectNews();
    if (!throttle_.isDue(topic + core::nameOf(outcome.status))) return;
    NODELET_WARN("%s: %s", topic.c_str(), core::describe(outcome).c_str());
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    const ros::Time now = ros::Time::now();
    std::string silence = "/clock has not begun";
    if (!now.isZero()) {
      silence = input_watch_->silence(now);
      if (!silence.empty() && throttle_.isDue("silence")) NODELET_WARN("%s", silence.c_str());
    }
    publisher_->diagnose(silence, &status);
  }

  template <typename Response, typename Work>
  bool serve(const char* service, Response* response, Work work) {
    const std::string error = guarded(service, work);
    if (!error.empty()) response->message = error;
    return true;  // false would tell the caller nothing
  }

  CalibrationNodeConfig config_;
  std::string wheel_topic_, bearing_topic_;
  std::unique_ptr<core::Calibrator> calibrator_;
  std::unique_ptr<CalibrationPublisher> publisher_;
  std::unique_ptr<InputWatch> input_watch_;
  std::deque<std::function<void(const ros::Time&)>> early_inputs_;  ///< before the first /clock
  ClockWatch clock_watch_;
  StampWatch stamp_watch_;
  std::unique_ptr<ResultSaver> saver_;
  ros::ServiceServer reset_service_, pause_service_, save_service_;
  std::vector<ros::Subscriber> wheel_subscribers_;
  ros::Subscriber bearing_subscriber_;
  ros::Timer transform_timer_;
};

}  // namespace bearing_calibration_ros

PLUGINLIB_EXPORT_CLASS(bearing_calibration_ros::CalibrationNodelet, nodelet::Nodelet)
