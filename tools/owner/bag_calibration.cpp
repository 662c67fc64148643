#include "tools/owner/bag_calibration.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>

#include <algorithm>
#include <map>
#include <set>
#include <variant>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/vision/image_advice.h"
#include "bearing_calibration_ros/camera_rays.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/image_bearings.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/result_saver.h"
#include "bearing_calibration_ros/sensor_places.h"
#include "bearing_calibration_ros/wheel_input.h"
#include "tools/common/timing.h"
#include "tools/owner/bag_reader.h"

namespace bearing_calibration::core {
namespace {

namespace ros_side = bearing_calibration_ros;

BagReader openBag(const std::string& bag, const BagSetup& setup) {
  return {bag, setup.topics, setup.calibration.wheels.source};
}

/// Feeds a bag's messages to the calibration.
class Replay {
 public:
  Replay(const BagJob& job, const BagSetup& setup, BagOutcome* outcome)
      : job_(job),
        setup_(setup),
        outcome_(outcome),
        calibrator_(setup.calibration.calibrator),
        review_(setup.calibration.calibrator.initializer) {
    calibrator_.observe([this](const AssociationOutcome& of_image) {
      review_.add(of_image);
      has_news_ = true;
    });
    if (!outcome->topics.images.empty()) images_.emplace(setup.detection);
    if (setup.detection.detector.mirror_kind == MirrorKind::kNone) {
      rays_.emplace(setup.detection.sensor_frame, "camera_info beside the images");
    }
    if (!setup.calibration.resume) return;
    const ros_side::EarlierResult earlier = ros_side::readEarlierResult(setup.calibration);
    if (earlier.lasting) calibrator_.resume(*earlier.lasting);
    warn("resume", earlier.message);
  }

  void take(const BagMessage& message) {
    std::visit([this, &message](const auto& content) { add(content, message.received); },
               message.content);
    noteEstimate();
  }

  void finish();

 private:
  void warn(const std::string& kind, const std::string& text) { warnings_.emplace(kind, text); }

  void checkFrame(const std::string& frame, const std::string& of, const std::string& parameter,
                  const std::string& expected) {
    if (frame.empty() || ros_side::areOneFrame(frame, expected)) return;
    warn(parameter, "frame '" + frame + "' of the " + of + " is not " + parameter + " '" +
                        expected + "': taken as if it were");
  }

  void add(const geometry_msgs::PoseWithCovarianceStampedConstPtr& plan, const ros::Time&) {
    const auto& covariance = plan->pose.covariance;  // of x, y, z, roll, pitch, yaw
    const Eigen::Vector3d stddev =
        Eigen::Vector3d(covariance[0], covariance[7], covariance[35]).cwiseSqrt();
    std::vector<PlanRow>& plans = outcome_->plans;
    if (!plans.empty() && plans.back().stddev == stddev) return;  // it is said again and again
    plans.push_back({ros_side::stampFromRos(plan->header.stamp), stddev});
  }

  void add(const WheelTicksConstPtr& ticks, const ros::Time& received) {
    const Timing timing(&outcome_->times.estimation);
    calibrator_.addTicks(ros_side::countsFromMessage(*ticks), ros_side::stampFromRos(received));
  }

  void add(const sensor_msgs::JointStateConstPtr& joints, const ros::Time& received) {
    const Timing timing(&outcome_->times.estimation);
    const ros_side::WheelJoints& wheels = setup_.calibration.wheels.joints;
    if (const auto angles = ros_side::anglesFromMessage(*joints, wheels)) {
      calibrator_.addAngles(*angles, ros_side::stampFromRos(received));
    } else if (ros_side::namesEither(*joints, wheels)) {
      warn("joints", ros_side::describeMissing(wheels, *joints));
    } else {
      others_joints_ = ros_side::describeMissing(wheels, *joints);  // an arm's, for instance
    }
  }

  void add(const BagWheelCount& wheel, const ros::Time& received) {
    const Timing timing(&outcome_->times.estimation);
    calibrator_.addWheel(wheel.side, ros_side::countFromMessage(*wheel.count, received),
                         ros_side::stampFromRos(received));
  }

  void add(const nav_msgs::OdometryConstPtr& odometry, const ros::Time& received) {
    const Timing timing(&outcome_->times.estimation);
    checkFrame(odometry->child_frame_id, "odometry", "frames/base", setup_.calibration.frames.base);
    calibrator_.addOdometry(ros_side::odometryFromMessage(*odometry),
                            ros_side::stampFromRos(received));
  }

  void add(const LightBearingsConstPtr& bearings, const ros::Time& received) {
    checkFrame(bearings->header.frame_id, "bearings", "frames/sensor",
               setup_.calibration.frames.sensor);
    addBearings(ros_side::bearingsFromMessage(*bearings), ros_side::stampFromRos(received));
  }

  void addBearings(BearingSet bearings, Stamp received) {
    const Timing timing(&outcome_->times.estimation);
    if (job_.light_id) {
      auto& candidates = bearings.candidates;
      for (const Bearing& candidate : candidates) lights_.insert(candidate.light_id);
      candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                      [this](const Bearing& candidate) {
                                        return candidate.light_id != *job_.light_id;
                                      }),
                       candidates.end());
    }
    calibrator_.addBearings(bearings, received);
  }

  void add(const sensor_msgs::CameraInfoConstPtr& info, const ros::Time&) {
    if (rays_) rays_->add(info);
  }

  void add(const tf2_msgs::TFMessageConstPtr& static_transforms, const ros::Time&) {
    if (rays_) rays_->add(*static_transforms);
  }

  void add(const sensor_msgs::ImageConstPtr& image, const ros::Time& received) {
    auto refusal = ros_side::refusalOf(*image, setup_.detection.detector.sensor);
    if (!refusal && rays_) refusal = rays_->refusalOf(*image);
    if (refusal) {
      warn(refusal->kind, "images were left out (" + refusal->kind + "): " + refusal->text);
      return;
    }
    if (rays_) images_->setCamera(rays_->of(*image));
    ++outcome_->images;
    BearingSet bearings = [&] {
      const Timing timing(&outcome_->times.detection);
      return images_->detect(image, calibrator_.predictBearing(images_->middleOf(*image)));
    }();
    const std::optional<Advice> advice = adviceFor(setup_.detection.detector, images_->result());
    (advice && advice->kind == AdviceKind::kNothingBright ? out_of_view_ : advice_).add(advice);
    addBearings(std::move(bearings), ros_side::stampFromRos(received));
  }

  void add(const sensor_msgs::CompressedImageConstPtr& compressed, const ros::Time& received) {
    const sensor_msgs::ImageConstPtr image = [&] {
      const Timing timing(&outcome_->times.detection);
      return ros_side::decoded(*compressed);
    }();
    if (image) return add(image, received);
    warn("not decoded",
         "images were left out (not decoded): " + ros_side::describeUndecoded(*compressed));
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
  OfflineReport review_;
  std::optional<ros_side::ImageBearings> images_;
  std::optional<ros_side::CameraRays> rays_;  ///< none with a mirror
  AdviceTally advice_, out_of_view_;          ///< on the images, on those of no bright spot
  EstimateHistory history_;
  bool has_news_ = false;
  std::string others_joints_;      ///< what a message without the wheels' joints lacks
  std::set<std::int32_t> lights_;  ///< of all bearings, where only those of one are used
  std::map<std::string, std::string> warnings_;  ///< the first one of each kind
};

void Replay::finish() {
  const Timing timing(&outcome_->times.estimation);
  calibrator_.finish();
  outcome_->result = calibrator_.result();
  if (outcome_->result.ticks_used == 0 && !others_joints_.empty()) warn("joints", others_joints_);
  outcome_->review = review_.conclude(outcome_->result);
  outcome_->history = history_.take(outcome_->result);
  const OpticsLearner* learner = images_ && images_->learner() ? &*images_->learner() : nullptr;
  if (learner != nullptr && learner->learntValues() > 0) outcome_->optics = yamlOf(*learner);
  if (job_.light_id && lights_.count(*job_.light_id) == 0) {
    std::vector<std::string> others;
    for (const std::int32_t light : lights_) {
      others.push_back(light == kUnknownLight ? "none" : std::to_string(light));
    }
    warn("light", formatted("no bearing has the light_id %d, only: %s", *job_.light_id,
                            joined(others, ", ").c_str()));
  }
  std::optional<Advice> advice = advice_.take();
  const bool no_light = outcome_->result.state == CalibrationState::kWaitingForLight;
  if (!advice && no_light) advice = out_of_view_.take();
  if (advice) warn("advice", "on the images: " + advice->sentence);
  for (const auto& kind_and_text : warnings_) outcome_->warnings.push_back(kind_and_text.second);
}

}  // namespace

BagSetup readBagSetup(const std::vector<std::string>& config_files,
                      const std::vector<std::string>& assignments, const BagTopics& topics) {
  ros_side::ParameterFiles files;
  files.addNode("calibration", ros_side::packagedConfig("calibration.yaml"));
  files.addNode("detection", ros_side::packagedConfig("detection.yaml"));
  files.addNode("drive", ros_side::packagedConfig("drive.yaml"));  // its limits are the robot's
  for (const std::string& file : config_files) files.overlay(file);
  for (const std::string& assignment : assignments) files.set(assignment);
  BagSetup setup{ros_side::readCalibrationNodeConfig(files.reader("calibration")), {}, topics, {}};
  ros_side::ParamReader params = files.reader("detection");
  setup.detection.declare(params);
  setup.camera_errors = params.takeRequired();
  params.throwIfAnyError();
  return setup;
}

BagOutcome calibrateBag(const BagJob& job, const BagSetup& setup,
                        std::atomic<std::uint64_t>* progress) {
  BagOutcome outcome;
  {
    const Timing timing(&outcome.times.whole);
    BagReader reader = openBag(job.bag, setup);
    outcome.topics = reader.topics();
    if (!outcome.topics.images.empty() && !setup.camera_errors.empty()) {
      throw std::runtime_error("it holds images, and " + setup.camera_errors);
    }
    Replay replay(job, setup, &outcome);
    for (auto batch = reader.next(); !batch.empty(); batch = reader.next()) {
      for (const BagMessage& message : batch) replay.take(message);
      *progress += batch.size();
    }
    outcome.times.reading = reader.readingSeconds();
    replay.finish();
  }
  return outcome;
}

std::uint64_t countMessages(const BagJob& job, const BagSetup& setup) {
  return openBag(job.bag, setup).size();
}

std::vector<std::int32_t> listLights(const std::string& bag, const BagSetup& setup) {
  BagReader reader = openBag(bag, setup);
  if (!reader.topics().images.empty()) {
    throw std::runtime_error(
        "the lights of images cannot be distinguished: --each-light needs bearings");
  }
  std::set<std::int32_t> ids;
  for (auto batch = reader.next(); !batch.empty(); batch = reader.next()) {
    for (const BagMessage& message : batch) {
      const auto* bearings = std::get_if<LightBearingsConstPtr>(&message.content);
      if (bearings == nullptr) continue;
      for (const LightBearing& candidate : (*bearings)->candidates) {
        if (candidate.light_id != kUnknownLight) ids.insert(candidate.light_id);
      }
    }
  }
  return {ids.begin(), ids.end()};
}

}  // namespace bearing_calibration::core
