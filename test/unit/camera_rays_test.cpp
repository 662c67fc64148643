#include "bearing_calibration_ros/camera_rays.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/make_shared.hpp>
#include <limits>
#include <string>
#include <utility>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/detection_params.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

sensor_msgs::CameraInfo info() {
  sensor_msgs::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.D = {-0.2, 0.05, 1e-3, -2e-3, 0.01};
  info.K = {500.0, 0.0, 310.0, 0.0, 510.0, 245.0, 0.0, 0.0, 1.0};
  return info;
}

sensor_msgs::Image imageIn(const std::string& frame) {
  sensor_msgs::Image image;
  image.header.stamp = ros::Time(1.0);
  image.header.frame_id = frame;
  image.width = 640;
  image.height = 480;
  return image;
}

std::string kindOf(const std::optional<Refusal>& refusal) { return refusal ? refusal->kind : ""; }

tf2_msgs::TFMessage transform(const std::string& parent, const std::string& child, double x_m,
                              double z_m) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  geometry_msgs::TransformStamped& transform = message.transforms.front();
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform.translation.x = x_m;
  transform.transform.translation.z = z_m;
  transform.transform.rotation.x = transform.transform.rotation.z = -0.5;  // z ahead, x right
  transform.transform.rotation.y = transform.transform.rotation.w = 0.5;
  return message;
}

// Promise unharmed: bearings, predictions or odometry whose frame has a slash in front
TEST(Frames, AreTheSameWithASlashInFront) {
  EXPECT_TRUE(areOneFrame("camera", "/camera"));
  EXPECT_TRUE(areOneFrame("/camera", "camera"));
  EXPECT_FALSE(areOneFrame("/camera", "lidar"));
  EXPECT_FALSE(areOneFrame("left/camera", "camera"));
}

TEST(CameraInfo, GivesTheLensItsNumbers) {
  EXPECT_EQ(kindOf(refusalOf(info())), "");
  const core::Camera camera = cameraFromMessage(info());
  EXPECT_EQ(camera.lens, core::Lens::kPerspective);
  EXPECT_EQ(camera.focal_u_px, 500.0);
  EXPECT_EQ(camera.focal_v_px, 510.0);
  EXPECT_EQ(camera.centre_u_px, 310.0);
  EXPECT_EQ(camera.centre_v_px, 245.0);
  EXPECT_EQ(camera.distortion, (std::array<double, 8>{-0.2, 0.05, 1e-3, -2e-3, 0.01, 0, 0, 0}));
  sensor_msgs::CameraInfo fisheye = info();
  fisheye.distortion_model = "equidistant";
  fisheye.D = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(kindOf(refusalOf(fisheye)), "");
  EXPECT_EQ(cameraFromMessage(fisheye).lens, core::Lens::kFisheye);
  sensor_msgs::CameraInfo ideal = info();
  ideal.distortion_model = "";
  ideal.D.clear();
  EXPECT_EQ(kindOf(refusalOf(ideal)), "");
}

// As of OpenCV's fourteen, of which a rational polynomial has eight.
TEST(CameraInfo, MayHaveZerosBehindItsCoefficients) {
  for (const auto& [model, lens_has] :
       {std::pair<const char*, std::size_t>{"rational_polynomial", 8},
        {"plumb_bob", 5},
        {"equidistant", 4},
        {"", 0}}) {
    sensor_msgs::CameraInfo more = info();
    more.distortion_model = model;
    more.D.assign(lens_has, 0.1);
    const core::Camera camera = cameraFromMessage(more);
    more.D.resize(14, 0.0);
    EXPECT_EQ(kindOf(refusalOf(more)), "") << model;
    EXPECT_EQ(cameraFromMessage(more), camera) << model;
    more.D.back() = 1e-3;
    EXPECT_EQ(kindOf(refusalOf(more)), "distortion coefficients") << model;
  }
}

TEST(CameraInfo, OfNoCalibrationGivesNoRays) {
  sensor_msgs::CameraInfo zeros = info();
  zeros.K = {};
  EXPECT_EQ(kindOf(refusalOf(zeros)), "uncalibrated camera");
  sensor_msgs::CameraInfo broken = info();
  broken.K[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kindOf(refusalOf(broken)), "uncalibrated camera");
  sensor_msgs::CameraInfo unknown = info();
  unknown.distortion_model = "thin_prism";
  EXPECT_EQ(kindOf(refusalOf(unknown)), "distortion_model");
  EXPECT_NE(refusalOf(unknown)->text.find("'thin_prism'"), std::string::npos);
  sensor_msgs::CameraInfo short_of_one = info();
  short_of_one.distortion_model = "rational_polynomial";
  EXPECT_EQ(kindOf(refusalOf(short_of_one)), "distortion coefficients");
  short_of_one.distortion_model = "";
  EXPECT_EQ(kindOf(refusalOf(short_of_one)), "distortion coefficients");
}

// The centre of pixel (u, v) of the image lies in the middle of its 2 x 2 pixels of the region.
TEST(CameraInfo, OfABinnedRegionIsThatOfTheImage) {
  const core::Camera whole = cameraFromMessage(info());
  sensor_msgs::CameraInfo cut = info();
  cut.roi.x_offset = 100;
  cut.roi.y_offset = 60;
  cut.roi.width = 400;
  cut.roi.height = 300;
  cut.binning_x = cut.binning_y = 2;
  const core::Camera part = cameraFromMessage(cut);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), Eigen::Vector2d(150, 20)}) {
    const Eigen::Vector2d in_region = 2.0 * pixel + Eigen::Vector2d(0.5, 0.5);
    const Eigen::Vector2d in_whole = in_region + Eigen::Vector2d(100, 60);
    EXPECT_LT((*rayFromPixel(part, pixel) - *rayFromPixel(whole, in_whole)).norm(), 1e-9);
  }
}

TEST(CameraRays, SayWhatTheyLack) {
  CameraRays rays("mast", "/camera/camera_info");
  const sensor_msgs::Image image = imageIn("eye_optical");
  EXPECT_EQ(kindOf(rays.refusalOf(image)), "no camera_info");
  EXPECT_NE(rays.refusalOf(image)->text.find("/camera/camera_info"), std::string::npos);
  sensor_msgs::CameraInfo other = info();
  other.width = 1280;
  rays.add(boost::make_shared<sensor_msgs::CameraInfo>(other));
  EXPECT_EQ(kindOf(rays.refusalOf(image)), "wrong imager");
  other = info();
  other.K = {};
  rays.add(boost::make_shared<sensor_msgs::CameraInfo>(other));
  EXPECT_EQ(kindOf(rays.refusalOf(image)), "uncalibrated camera");
  // Many a driver without a calibration says nothing but zeros.
  rays.add(boost::make_shared<sensor_msgs::CameraInfo>());
  EXPECT_EQ(kindOf(rays.refusalOf(image)), "uncalibrated camera");
  rays.add(boost::make_shared<sensor_msgs::CameraInfo>(info()));
  EXPECT_EQ(kindOf(rays.refusalOf(image)), "no static transform");
  EXPECT_EQ(kindOf(rays.refusalOf(imageIn("mast"))), "frame of the image");
  EXPECT_EQ(kindOf(rays.refusalOf(imageIn(""))), "frame_id is empty");
  rays.add(transform("mast", "eye_optical", 0.0, 0.3));
  EXPECT_EQ(kindOf(rays.refusalOf(image)), "");
  EXPECT_EQ(kindOf(rays.refusalOf(imageIn("/eye_optical"))), "");
  rays.add(transform("mast", "other_optical", 0.01, 0.3));
  EXPECT_EQ(kindOf(rays.refusalOf(imageIn("other_optical"))), "lens beside frames/sensor");
  rays.add(transform("mast", "far_optical", std::numeric_limits<double>::infinity(), 0.3));
  EXPECT_EQ(kindOf(rays.refusalOf(imageIn("far_optical"))), "static transform not finite");
}

TEST(CameraRays, AreTurnedAsTheStaticTransformSays) {
  CameraRays rays("/mast", "");
  rays.add(boost::make_shared<sensor_msgs::CameraInfo>(info()));
  rays.add(transform("mast", "eye_optical", 0.0, 0.0));
  const core::Camera camera = rays.of(imageIn("eye_optical"));
  EXPECT_LT((camera.sensor_from_optical - core::Camera().sensor_from_optical).norm(), 1e-12);
}

TEST(CameraRays, AreThoseOfAFrameWithZUp) {
  DetectionNodeConfig config;
  config.sensor_frame = "eye_optical";
  const auto names_the_frame = [&] {
    const std::string errors = core::joined(core::errorsOf(config), "; ");
    return errors.find("frames/sensor must have z up") != std::string::npos;
  };
  EXPECT_FALSE(names_the_frame()) << "with a mirror";
  config.detector.mirror_kind = core::MirrorKind::kNone;
  EXPECT_TRUE(names_the_frame());
}

}  // namespace
}  // namespace bearing_calibration_ros
