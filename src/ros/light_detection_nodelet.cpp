#include <bearing_calibration/FindMirror.h>
#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/PredictedBearing.h>
#include <image_transport/camera_common.h>
#include <image_transport/image_transport.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/image_advice.h"
#include "bearing_calibration_ros/camera_rays.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/detection_diagnostics.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/image_bearings.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/image_input.h"
#include "bearing_calibration_ros/optics_file.h"
#include "bearing_calibration_ros/rig_checks.h"
#include "bearing_calibration_ros/threshold_server.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

/// Images of a conic mirror, or of a camera without one, in, bearings of the light out: one message
/// for each image.
///
/// Threading: every subscriber and timer hangs on getNodeHandle()'s queue, which a nodelet manager
/// serves with one thread at a time. So no callback runs beside another, and nothing here is
/// locked.
class LightDetectionNodelet : public GuardedNodelet {
 public:
  ~LightDetectionNodelet() override { endCallbacks(); }

 private:
  void start() override {
    config_ = readConfig<DetectionNodeConfig>(ParamReader(getPrivateNodeHandle()));
    keepOptics();
    bearings_ = std::make_unique<ImageBearings>(config_);
    // Before the first callback may want to name them: the queue is served already.
    image_topic_ = getNodeHandle().resolveName("image");
    camera_info_topic_ = image_transport::getCameraInfoTopic(image_topic_);
    prediction_topic_ = getNodeHandle().resolveName("predicted_bearing");
    if (config_.detector.mirror_kind == core::MirrorKind::kNone) {
      rays_ = std::make_unique<CameraRays>(config_.sensor_frame, camera_info_topic_);
    }
    advertise();
    subscribe();
  }

  void keepOptics() {
    const std::string& folder = config_.optics_folder;
    if (folder.empty() || config_.detector.mirror_kind != core::MirrorKind::kCone) return;
    const std::string why = whyNotWritable(folder);
    if (!why.empty()) throw std::runtime_error("optics/folder " + why);
    optics_file_ = std::make_unique<OpticsFile>(folder, getName());
  }

  void advertise() {
    constexpr std::uint32_t kBearingQueue = 100;  // 10 s at 10 Hz: the calibration may lag
    constexpr bool kLatched = true;
    ros::NodeHandle& private_node_handle = getPrivateNodeHandle();
    bearings_publisher_ = getNodeHandle().advertise<msg::LightBearings>("bearings", kBearingQueue);
    annotated_publisher_ =
        image_transport::ImageTransport(private_node_handle).advertise("annotated", 1);
    advice_publisher_ = private_node_handle.advertise<std_msgs::String>("advice", 1, kLatched);
    mirror_service_ = private_node_handle.advertiseService(
        "find_mirror", &LightDetectionNodelet::onFindMirror, this);
    thresholds_ = std::make_unique<ThresholdServer>(
        private_node_handle, config_.detector,
        [this](const core::DetectorConfig& detector) { takeThresholds(detector); },
        [this](bool is_taken, const std::string& said) { say(is_taken, said); });
  }

  void subscribe() {
    camera_info_subscriber_ = listenTo<sensor_msgs::CameraInfo>(
        camera_info_topic_, 1, [this](const auto& message) { takeCameraInfo(message); });
    if (rays_) {
      constexpr std::uint32_t kStaticQueue = 100;  // one message from each of their publishers
      static_subscriber_ = listenTo<tf2_msgs::TFMessage>(
          "/tf_static", kStaticQueue, [this](const auto& message) { rays_->add(*message); });
    }
    prediction_subscriber_ = listenTo<msg::PredictedBearing>(
        "predicted_bearing", 1, [this](const auto& message) { takePrediction(*message); });
    image_input_ = std::make_unique<ImageInput>(
        getNodeHandle(), getPrivateNodeHandle(), config_.image_queue,
        [this](const sensor_msgs::ImageConstPtr& image) { onImage(image); },
        [this](const Refusal& refusal) { refuse(refusal); });
    startDiagnostics("light detection", [this](auto& status) { diagnose(status); });
  }

  void onImage(const sensor_msgs::ImageConstPtr& message) {
    guarded("image", [&] {
      if (const auto refusal = refusalOfImage(*message)) return refuse(*refusal);
      last_image_ = message;
      if (rays_) bearings_->setCamera(rays_->of(*message));
      bearings_publisher_.publish(
          messageFromBearings(bearings_->detect(message, prediction_), config_.sensor_frame));
      const core::DetectionResult& result = bearings_->result();
      addTo(&counts_, result);
      is_used_ = true;
      images_of_late_.see(result);
      advice_tally_.add(core::adviceFor(config_.detector, result));
      if (annotated_publisher_.getNumSubscribers() > 0) publishAnnotated(message->header, result);
    });
  }

  std::optional<Refusal> refusalOfImage(const sensor_msgs::Image& image) const {
    const core::ImageSensor& sensor = config_.detector.sensor;
    if (const auto refusal = refusalOf(image, sensor)) return refusal;
    if (rays_) return rays_->refusalOf(image);
    if (!config_.camera_info_required || (camera_info_ && camera_info_->isOf(sensor))) {
      return std::nullopt;
    }
    if (camera_info_ && camera_info_->isSaid()) {
      return Refusal{"wrong imager", camera_info_topic_ + ": " + camera_info_doubt_};
    }
    const std::string required = "camera_info/required is set, but ";
    if (camera_info_) {
      return Refusal{"empty camera_info", required + camera_info_topic_ + " says 0x0"};
    }
    return Refusal{"no camera_info", required + "nothing came on " + camera_info_topic_};
  }

  void takeCameraInfo(const sensor_msgs::CameraInfoConstPtr& message) {
    camera_info_ = deliveredImage(*message);
    std::string doubt = contradiction(*camera_info_, config_.detector);
    if (rays_) {
      rays_->add(message);
      const auto refusal = refusalOf(*message);
      if (refusal && doubt.empty()) doubt = refusal->text;
    }
    if (!doubt.empty() && doubt != camera_info_doubt_) {
      NODELET_WARN("%s: %s", camera_info_topic_.c_str(), doubt.c_str());
    }
    camera_info_doubt_ = doubt;
  }

  std::string describeCameraInfo() const {
    if (!camera_info_) return "none has come";
    if (!camera_info_doubt_.empty()) return camera_info_doubt_;
    return camera_info_->isSaid() ? "fits" : "says nothing: 0x0";
  }

  void refuse(const Refusal& refusal) {
    countRefused(refusal.kind);
    if (!throttle_.isDue(refusal.kind)) return;
    NODELET_WARN("%s: image ignored (%s): %s", image_topic_.c_str(), refusal.kind.c_str(),
                 refusal.text.c_str());
  }

  void onError(const std::string& callback, const std::string& error) override {
    countRefused(callback);
    GuardedNodelet::onError(callback, error);
  }

  void countRefused(const std::string& kind) {
    ++counts_["images refused: " + kind];
    is_refused_ = true;
  }

  void takePrediction(const msg::PredictedBearing& message) {
    checkFrame(prediction_topic_, message.header.frame_id, "frames/sensor", config_.sensor_frame);
    prediction_ = predictionFromMessage(message);
  }

  void publishAnnotated(const std_msgs::Header& header, const core::DetectionResult& result) {
    const cv::Mat picture = core::annotate(bearings_->grey(), result, config_.detector);
    annotated_publisher_.publish(imageMessage(header, sensor_msgs::image_encodings::BGR8, picture));
  }

  bool onFindMirror(msg::FindMirror::Request& request, msg::FindMirror::Response& response) {
    response = noMirror(last_image_ ? "the newest image cannot be read: see the log"
                                    : "no image has come yet on " + image_topic_);
    guarded("find_mirror", [&] {
      GreyConverter converter;
      if (last_image_) response = findMirror(converter.convert(last_image_), config_.detector);
      if (request.apply && response.found) applyCentre(&response);
    });
    NODELET_INFO("find_mirror: %s", response.text.c_str());
    return true;
  }

  void applyCentre(msg::FindMirror::Response* response) {
    core::DetectorConfig detector = config_.detector;
    detector.view.centre_u_px = response->centre_u;
    detector.view.centre_v_px = response->centre_v;
    const std::string refusal = thrownBy([&] { lookWith(core::validated(detector)); });
    response->applied = refusal.empty();
    response->text += refusal.empty() ? "; the centre is applied until this node ends: call ~reset "
                                        "of the calibration, and write it into your file"
                                      : "; the centre is not applied: " + refusal;
  }

  void takeThresholds(const core::DetectorConfig& changed) {
    core::DetectorConfig detector = config_.detector;
    detector.threshold = changed.threshold;
    detector.gates = changed.gates;
    lookWith(detector);
  }

  void lookWith(const core::DetectorConfig& detector) {
    bearings_->setDetector(detector);
    config_.detector = detector;
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    const std::optional<core::Advice> advice = advice_tally_.take();
    if (is_used_) publishAdvice(advice);
    if (is_used_ || is_refused_) images_of_late_.refused = is_refused_;
    is_used_ = is_refused_ = false;
    images_of_late_.silent = image_input_->isSilent();
    counts_["images dropped for newer ones"] = image_input_->dropped();
    fillDiagnostics(counts_, images_of_late_, &status);
    status.add("camera_info", describeCameraInfo());
    if (const auto& learner = bearings_->learner()) {
      if (optics_file_) optics_file_->see(*learner);
      fillOptics(*learner, &status);
    }
  }

  /// Published when its figures change, logged when its kind does. An empty text says that nothing
  /// is to be changed.
  void publishAdvice(const std::optional<core::Advice>& advice) {
    std_msgs::String message;
    if (advice) message.data = advice->sentence;
    const std::optional<core::Advice>& before = images_of_late_.advice;
    const bool is_news = advice && !(before && before->kind == advice->kind);
    if (is_news) NODELET_INFO("advice: %s", message.data.c_str());
    const std::string said = before ? before->sentence : std::string();
    if (message.data != said) advice_publisher_.publish(message);
    images_of_late_.advice = advice;
  }

  DetectionNodeConfig config_;
  std::unique_ptr<OpticsFile> optics_file_;  ///< none where nothing is kept
  std::unique_ptr<ImageBearings> bearings_;
  std::optional<core::BearingPrediction> prediction_;
  std::optional<DeliveredImage> camera_info_;
  std::unique_ptr<CameraRays> rays_;  ///< none with a mirror
  std::string camera_info_doubt_;
  sensor_msgs::ImageConstPtr last_image_;  ///< that could be used

  Counts counts_{{"images used", 0}};
  bool is_used_ = false, is_refused_ = false;  ///< an image, since the last diagnostics
  core::AdviceTally advice_tally_;
  ImagesOfLate images_of_late_;
  ros::Publisher bearings_publisher_, advice_publisher_;
  ros::ServiceServer mirror_service_;
  std::unique_ptr<ThresholdServer> thresholds_;
  image_transport::Publisher annotated_publisher_;
  std::string image_topic_, camera_info_topic_, prediction_topic_;
  std::unique_ptr<ImageInput> image_input_;
  ros::Subscriber camera_info_subscriber_, static_subscriber_, prediction_subscriber_;
};

}  // namespace bearing_calibration_ros

PLUGINLIB_EXPORT_CLASS(bearing_calibration_ros::LightDetectionNodelet, nodelet::Nodelet)
