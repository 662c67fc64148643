#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/PredictedBearing.h>
#include <diagnostic_msgs/DiagnosticStatus.h>
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/input/point_bearing.h"
#include "bearing_calibration/input/scan_bearings.h"
#include "bearing_calibration_ros/adapter_params.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/sensor_places.h"

namespace bearing_calibration_ros {
namespace {

std::vector<geometry_msgs::Point> pointsOf(const geometry_msgs::PointStamped& message) {
  return {message.point};
}
std::vector<geometry_msgs::Point> pointsOf(const geometry_msgs::PoseStamped& message) {
  return {message.pose.position};
}
std::vector<geometry_msgs::Point> pointsOf(const geometry_msgs::PoseArray& message) {
  std::vector<geometry_msgs::Point> points;
  for (const geometry_msgs::Pose& pose : message.poses) points.push_back(pose.position);
  return points;
}

}  // namespace

/// Points, poses, transforms or laser scans in, bearings of the light out.
///
/// Threading: as in LightDetectionNodelet, no callback runs beside another.
class BearingAdapterNodelet : public GuardedNodelet {
 public:
  ~BearingAdapterNodelet() override { endCallbacks(); }

 private:
  void start() override {
    config_ = readConfig<AdapterNodeConfig>(ParamReader(getPrivateNodeHandle()));
    places_ = std::make_unique<SensorPlaces>(config_.sensor_frame);
    const bool is_tf = config_.source == BearingSource::kTf;
    input_topic_ = getNodeHandle().resolveName(is_tf ? "/tf" : "input");
    prediction_topic_ = getNodeHandle().resolveName("predicted_bearing");
    constexpr std::uint32_t kBearingQueue = 100;  // 10 s at 10 Hz: the calibration may lag
    bearings_publisher_ = getNodeHandle().advertise<msg::LightBearings>("bearings", kBearingQueue);
    subscribe();
    std::string frames;
    for (const auto& [frame, light_id] : config_.lights_by_frame) {
      frames += (frames.empty() ? " for " : ", ") + frame;
    }
    const std::string input = input_topic_ + (is_tf ? frames : "");
    startDiagnostics("bearing adapter",
                     [this, input](auto& status) { fillDiagnostics(input, &status); });
  }

  void subscribe() {
    constexpr bool kOnce = true;
    constexpr bool kStarts = false;
    static_subscriber_ = listenTo<tf2_msgs::TFMessage>(
        "/tf_static", kQueue, [this](const auto& message) { places_->add(*message); });
    switch (config_.source) {
      case BearingSource::kPoint:
        input_subscriber_ = listenToPoints<geometry_msgs::PointStamped>();
        break;
      case BearingSource::kPose:
        input_subscriber_ = listenToPoints<geometry_msgs::PoseStamped>();
        break;
      case BearingSource::kPoses:
        input_subscriber_ = listenToPoints<geometry_msgs::PoseArray>();
        break;
      case BearingSource::kTf:
        image_timer_ = getNodeHandle().createWallTimer(
            ros::WallDuration(kImage_s),
            [this](const auto&) { guarded("tf", [this] { publishTransforms(); }); }, kOnce,
            kStarts);
        input_subscriber_ = listenTo<tf2_msgs::TFMessage>(
            input_topic_, kQueue, [this](const auto& message) { addTransforms(*message); });
        break;
      case BearingSource::kScan:
        prediction_subscriber_ = listenTo<msg::PredictedBearing>(
            prediction_topic_, kQueue, [this](const auto& message) { takePrediction(*message); });
        input_subscriber_ = listenTo<sensor_msgs::LaserScan>(
            input_topic_, kQueue, [this](const auto& message) { takeScan(*message); });
        break;
    }
  }

  template <class Message>
  ros::Subscriber listenToPoints() {
    return listenTo<Message>(input_topic_, kQueue, [this](const auto& message) {
      takePoints(message->header, pointsOf(*message));
    });
  }

  void takePoints(const std_msgs::Header& header, const std::vector<geometry_msgs::Point>& points) {
    const std::optional<Eigen::Isometry3d> sensor_from_frame = place(header);
    if (!sensor_from_frame) return;
    const bool is_one = config_.source != BearingSource::kPoses;
    const int light_id = is_one ? config_.light_id : core::kUnknownLight;
    core::BearingSet set{stampFromRos(header.stamp), {}};
    for (const geometry_msgs::Point& point : points) {
      add({point.x, point.y, point.z}, *sensor_from_frame, light_id, &set);
    }
    if (points.empty() || !set.candidates.empty()) publish(set);
  }

  /// Detectors send the transforms of one image one by one, but bearings of one stamp are one
  /// message: they are collected until all lights or the next image have come, or for a while.
  void addTransforms(const tf2_msgs::TFMessage& message) {
    for (const geometry_msgs::TransformStamped& transform : message.transforms) {
      const auto light = config_.lights_by_frame.find(withoutSlash(transform.child_frame_id));
      if (light == config_.lights_by_frame.end()) continue;
      const ros::Time last = std::exchange(last_seen_[light->first], transform.header.stamp);
      if (transform.header.stamp == last && !last.isZero()) continue;  // sent again
      const std::optional<Eigen::Isometry3d> sensor_from_frame = place(transform.header);
      if (!sensor_from_frame) continue;
      const core::Stamp stamp = stampFromRos(transform.header.stamp);
      if (image_.stamp != stamp) publishTransforms();
      image_.stamp = stamp;
      const geometry_msgs::Vector3& point = transform.transform.translation;
      add({point.x, point.y, point.z}, *sensor_from_frame, light->second, &image_);
      if (image_.candidates.size() == config_.lights_by_frame.size()) publishTransforms();
      image_timer_.stop();
      image_timer_.start();
    }
  }

  void publishTransforms() {
    if (!image_.candidates.empty()) publish(image_);
    image_.candidates.clear();
  }

  void takePrediction(const msg::PredictedBearing& message) {
    checkFrame(prediction_topic_, message.header.frame_id, "frames/sensor", config_.sensor_frame);
    prediction_ = predictionFromMessage(message);
  }

  void takeScan(const sensor_msgs::LaserScan& message) {
    const std::optional<Eigen::Isometry3d> sensor_from_frame = place(message.header);
    if (!sensor_from_frame) return;
    const core::LaserScan scan = scanFromMessage(message);
    const std::string refusal = core::whyUnusable(scan, config_.scan);
    if (!refusal.empty()) return refuse(refusal, "the scan is ignored");
    publish(core::bearingsInScan(scan, config_.scan, *sensor_from_frame, config_.azimuth_stddev_rad,
                                 prediction_));
  }

  void add(const Eigen::Vector3d& point, const Eigen::Isometry3d& sensor_from_frame, int light_id,
           core::BearingSet* set) {
    const Eigen::Vector3d in_sensor = sensor_from_frame * point;
    const char* refusal = core::whyNoPoint(point);
    if (refusal == nullptr) refusal = core::whyNoAzimuth(in_sensor);
    if (refusal != nullptr) {
      return refuse(refusal,
                    core::formatted("(%g, %g, %g) m is left out", point.x(), point.y(), point.z()));
    }
    set->candidates.push_back(core::bearingOfPoint(in_sensor, config_.azimuth_stddev_rad));
    set->candidates.back().light_id = light_id;
  }

  /// Where the frame of a message that has come is in the sensor's; none, and a word, where nobody
  /// knows.
  std::optional<Eigen::Isometry3d> place(const std_msgs::Header& header) {
    ++counts_["messages"];
    silence_.saw(ros::SteadyTime::now().toSec());
    const std::optional<Refusal> refusal = places_->refusalOf(header);
    if (!refusal) return places_->sensorFrom(header.frame_id);
    refuse(refusal->kind, "the message is ignored: " + refusal->text);
    return std::nullopt;
  }

  void publish(const core::BearingSet& set) {
    counts_["messages with a candidate"] += set.candidates.empty() ? 0 : 1;
    bearings_publisher_.publish(messageFromBearings(set, config_.sensor_frame));
  }

  void refuse(const std::string& kind, const std::string& text) {
    countRefused(kind);
    if (!throttle_.isDue(kind)) return;
    NODELET_WARN("%s: %s: %s", input_topic_.c_str(), kind.c_str(), text.c_str());
  }

  void onError(const std::string& callback, const std::string& error) override {
    countRefused(callback);
    GuardedNodelet::onError(callback, error);
  }

  void countRefused(const std::string& kind) {
    ++counts_["refused: " + kind];
    refused_of_late_ = kind;
  }

  /// A warning when nothing comes or something was refused since the last call; fine otherwise.
  void fillDiagnostics(const std::string& input,
                       diagnostic_updater::DiagnosticStatusWrapper* status) {
    using Status = diagnostic_msgs::DiagnosticStatus;
    status->summary(Status::OK, input + " is read");
    if (silence_.isSilent(ros::SteadyTime::now().toSec())) {
      status->summary(Status::WARN, "nothing comes on " + input);
    }
    if (!refused_of_late_.empty()) {
      status->summary(Status::WARN, input + " is refused: " + refused_of_late_);
    }
    for (const auto& [what, count] : counts_) status->add(what, count);
    refused_of_late_.clear();
  }

  static constexpr double kImage_s = 0.5;        ///< in which the transforms of an image arrive
  static constexpr std::uint32_t kQueue = 1000;  ///< a busy /tf for seconds, as a player sends it

  AdapterNodeConfig config_;
  std::unique_ptr<SensorPlaces> places_;
  std::optional<core::BearingPrediction> prediction_;
  core::BearingSet image_;                      ///< of transforms, not yet published
  std::map<std::string, ros::Time> last_seen_;  ///< by frame
  Counts counts_{{"messages", 0}, {"messages with a candidate", 0}};
  std::string refused_of_late_;
  SilenceWatch silence_;
  std::string input_topic_, prediction_topic_;
  ros::Publisher bearings_publisher_;
  ros::Subscriber static_subscriber_, prediction_subscriber_, input_subscriber_;
  ros::WallTimer image_timer_;
};

}  // namespace bearing_calibration_ros

PLUGINLIB_EXPORT_CLASS(bearing_calibration_ros::BearingAdapterNodelet, nodelet::Nodelet)
