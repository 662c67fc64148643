#include "tools/bag_calibration.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <set>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/image_bearings.h"
#include "bearing_calibration_ros/tick_message.h"

namespace bearing_calibration {
namespace {

namespace ros_side = bearing_calibration_ros;
using SteadyClock = std::chrono::steady_clock;

/// Adds the time until its end to a sum [s].
class Timing {
 public:
  explicit Timing(double* sum_s) : sum_s_(sum_s) {}
  ~Timing() { *sum_s_ += std::chrono::duration<double>(SteadyClock::now() - start_).count(); }
  Timing(const Timing&) = delete;
  Timing& operator=(const Timing&) = delete;

 private:
  double* sum_s_;
  SteadyClock::time_point start_ = SteadyClock::now();
};

/// A bag that is open, with the topics that are read of it.
struct OpenBag {
  OpenBag(const std::string& path, const BagSetup& setup) {
    // opening loads rosbag's plugins, which is not made for several threads
    static std::mutex opening;
    const std::lock_guard<std::mutex> lock(opening);
    bag.open(path, rosbag::bagmode::Read);
    rosbag::View whole(bag);
    topics = findTopics(whole, setup.topics, setup.calibration.wheel_source);
    view.addQuery(bag, rosbag::TopicQuery(topics.names()));
  }

  rosbag::Bag bag;
  BagTopics topics;
  rosbag::View view;
};

/// The running estimate, often enough to be drawn and never too long to be kept.
class History {
 public:
  bool isDue(double distance_m, CalibrationState state) const {
    return rows_.empty() || state != rows_.back().state ||
           distance_m >= rows_.back().distance_m + step_m_;
  }

  void add(const CalibrationResult& result) {
    rows_.push_back(
        {result.stamp, result.distance_travelled_m, result.state, *result.base_from_sensor});
    constexpr std::size_t kMostRows = 4000;  // more than a plot has pixels
    if (rows_.size() < kMostRows) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows_.size(); i += 2) rows_[kept++] = rows_[i];
    rows_.resize(kept);
    step_m_ *= 2.0;
  }

  std::vector<EstimateRow> take() { return std::move(rows_); }

 private:
  std::vector<EstimateRow> rows_;
  double step_m_ = 0.01;
};

/// Feeds a bag's messages to the calibration.
class Replay {
 public:
  Replay(const BagJob& job, const BagSetup& setup, BagOutcome* outcome)
      : job_(job),
        setup_(setup),
        outcome_(outcome),
        calibrator_(setup.calibration.calibrator),
        review_(setup.calibration.calibrator.initializer) {
    calibrator_.observe([this](const Look& look) {
      review_.add(look);
      has_news_ = true;
    });
    if (!outcome->topics.images.empty()) images_.emplace(setup.detection);
  }

  void read(const rosbag::MessageInstance& message) {
    const Stamp received = ros_side::stampFromRos(message.getTime());
    if (const auto plan = message.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
      addPlan(*plan);
    } else if (const auto ticks = message.instantiate<WheelTicks>()) {
      const Timing timing(&outcome_->times.estimation);
      calibrator_.addTicks(ros_side::countsFromMessage(*ticks), received);
    } else if (const auto joints = message.instantiate<sensor_msgs::JointState>()) {
      addJoints(*joints, received);
    } else if (const auto bearings = message.instantiate<LightBearings>()) {
      checkFrame(bearings->header.frame_id);
      addBearings(ros_side::bearingsFromMessage(*bearings), received);
    } else if (const auto image = message.instantiate<sensor_msgs::Image>()) {
      addImage(image, received);
    } else if (const auto count = message.instantiate<topic_tools::ShapeShifter>()) {
      addWheel(message.getTopic(), *count, message.getTime());
    }
    noteEstimate();
  }

  void finish();

 private:
  void warn(const std::string& kind, const std::string& text) { warnings_.emplace(kind, text); }

  void checkFrame(const std::string& frame) {
    const std::string& expected = setup_.calibration.frames.sensor;
    if (frame.empty() || frame == expected) return;
    warn("frame", "frame '" + frame + "' of the bearings is not frames/sensor '" + expected +
                      "': taken as if it were");
  }

  void addPlan(const geometry_msgs::PoseWithCovarianceStamped& expected) {
    const auto& covariance = expected.pose.covariance;  // of x, y, z, roll, pitch, yaw
    const Eigen::Vector3d stddev =
        Eigen::Vector3d(covariance[0], covariance[7], covariance[35]).cwiseSqrt();
    std::vector<PlanRow>& plans = outcome_->plans;
    if (!plans.empty() && plans.back().stddev == stddev) return;  // it is said again and again
    plans.push_back({ros_side::stampFromRos(expected.header.stamp), stddev});
  }

  void addJoints(const sensor_msgs::JointState& joints, Stamp received) {
    const Timing timing(&outcome_->times.estimation);
    const ros_side::WheelJoints& wheels = setup_.calibration.joints;
    if (const auto angles = ros_side::anglesFromMessage(joints, wheels)) {
      calibrator_.addAngles(*angles, received);
    } else {
      warn("joints", "joint states without '" + wheels.left + "' and '" + wheels.right +
                         "' were left out; the first has (" + ros_side::jointNames(joints) + ")");
    }
  }

  void addWheel(const std::string& topic, const topic_tools::ShapeShifter& count,
                const ros::Time& received) {
    const Timing timing(&outcome_->times.estimation);
    const WheelSide side = topic == outcome_->topics.wheels ? WheelSide::kLeft : WheelSide::kRight;
    calibrator_.addWheel(side, ros_side::countFromMessage(count, received),
                         ros_side::stampFromRos(received));
  }

  void addBearings(BearingSet bearings, Stamp received) {
    const Timing timing(&outcome_->times.estimation);
    if (job_.light_id) {
      auto& candidates = bearings.candidates;
      candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                      [this](const Bearing& candidate) {
                                        return candidate.light_id != *job_.light_id;
                                      }),
                       candidates.end());
    }
    calibrator_.addBearings(bearings, received);
  }

  void addImage(const sensor_msgs::ImageConstPtr& image, Stamp received) {
    if (const auto refusal = ros_side::refusalOf(*image, setup_.detection.detector.sensor)) {
      warn(refusal->kind, "images were left out (" + refusal->kind + "): " + refusal->text);
      return;
    }
    ++outcome_->images;
    BearingSet bearings;
    {
      const Timing timing(&outcome_->times.detection);
      bearings = images_->detect(image, calibrator_.predictBearing(images_->middleOf(*image)));
    }
    addBearings(std::move(bearings), received);
  }

  void noteEstimate() {
    if (!has_news_) return;
    has_news_ = false;
    const Timing timing(&outcome_->times.estimation);
    const CalibrationResult result = calibrator_.result();
    if (result.base_from_sensor && history_.isDue(result.distance_travelled_m, result.state)) {
      history_.add(result);
    }
  }

  const BagJob& job_;
  const BagSetup& setup_;
  BagOutcome* outcome_;
  Calibrator calibrator_;
  RecordReview review_;
  std::optional<ros_side::ImageBearings> images_;
  History history_;
  bool has_news_ = false;
  std::map<std::string, std::string> warnings_;  ///< the first one of each kind
};

void Replay::finish() {
  const Timing timing(&outcome_->times.estimation);
  CalibrationResult& result = outcome_->result;
  result = calibrator_.result();
  std::optional<RobotEstimate> running;
  if (result.cartesian_state) running = {*result.cartesian_state, result.robot_errors};
  outcome_->review = review_.conclude(running);
  outcome_->history = history_.take();
  for (const auto& kind_and_text : warnings_) outcome_->warnings.push_back(kind_and_text.second);
  if (!outcome_->review.estimate) return;
  if (!result.cartesian_state) {
    result.state = CalibrationState::kConverging;
    result.advice =
        "found in the record as a whole only: drive longer, so that it can be confirmed";
  }
  result.cartesian_state = outcome_->review.estimate->cartesian;
  result.robot_errors = outcome_->review.estimate->errors;
  result.paper_state = paperFromCartesian(*result.cartesian_state);
  result.base_from_sensor = mountFromCartesian(*result.cartesian_state);
}

}  // namespace

BagOutcome calibrateBag(const BagJob& job, const BagSetup& setup,
                        std::atomic<std::uint64_t>* progress) {
  BagOutcome outcome;
  {
    const Timing timing(&outcome.times.whole);
    OpenBag open(job.bag, setup);
    outcome.topics = open.topics;
    Replay replay(job, setup, &outcome);
    for (const rosbag::MessageInstance& message : open.view) {
      replay.read(message);
      ++*progress;
    }
    replay.finish();
  }
  return outcome;
}

std::uint64_t countMessages(const BagJob& job, const BagSetup& setup) {
  return OpenBag(job.bag, setup).view.size();
}

std::vector<std::int32_t> listLights(const std::string& bag, const BagSetup& setup) {
  OpenBag open(bag, setup);
  if (!open.topics.images.empty()) {
    throw std::runtime_error(
        "the lights of images cannot be told apart: --each-light wants bearings");
  }
  std::set<std::int32_t> ids;
  for (const rosbag::MessageInstance& message : open.view) {
    const auto bearings = message.instantiate<LightBearings>();
    if (!bearings) continue;
    for (const LightBearing& candidate : bearings->candidates) {
      if (candidate.light_id != kUnknownLight) ids.insert(candidate.light_id);
    }
  }
  return {ids.begin(), ids.end()};
}

}  // namespace bearing_calibration
