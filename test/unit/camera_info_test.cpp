#include <gtest/gtest.h>

#include <limits>

#include "bearing_calibration/optics/conic_mirror.h"
#include "bearing_calibration_ros/rig_checks.h"
#include "support/default_rig.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

core::DetectorConfig detector() {
  core::DetectorConfig config;
  config.sensor.width_px = 640;
  config.sensor.height_px = 480;
  config.mirror = core::test::defaultMirror();
  return config;
}

sensor_msgs::CameraInfo infoOf(std::uint32_t width, std::uint32_t height) {
  sensor_msgs::CameraInfo info;
  info.width = width;
  info.height = height;
  return info;
}

std::string contradictionOf(const sensor_msgs::CameraInfo& info) {
  return contradiction(deliveredImage(info), detector());
}

TEST(CameraInfo, AnUncalibratedCamerasSaysNothing) {
  EXPECT_FALSE(deliveredImage(infoOf(0, 0)).isSaid());
  EXPECT_EQ(contradictionOf(infoOf(0, 0)), "");
}

// REP 104: width, height and K are the whole imager's; the image is cut out, then binned.
TEST(CameraInfo, TheImageIsTheRegionBinned) {
  sensor_msgs::CameraInfo info = infoOf(1280, 960);
  EXPECT_NE(contradictionOf(info), "");
  info.binning_x = info.binning_y = 2;
  EXPECT_EQ(contradictionOf(info), "");
  info = infoOf(3000, 2000);
  info.roi.x_offset = 7;
  info.roi.width = 640;
  info.roi.height = 480;
  EXPECT_EQ(contradictionOf(info), "");
  info.binning_x = info.binning_y = 1;
  EXPECT_EQ(contradictionOf(info), "");
  info.roi.width = 1280;
  info.roi.height = 960;
  info.binning_x = info.binning_y = 2;
  EXPECT_EQ(contradictionOf(info), "");
}

TEST(CameraInfo, TheFocalLengthIsBinnedToo) {
  const double focal_length_px = core::imageDistancePx(core::test::defaultMirror());
  sensor_msgs::CameraInfo info = infoOf(640, 480);
  info.K[0] = focal_length_px;
  EXPECT_EQ(contradictionOf(info), "");
  info.K[0] = 2.0 * focal_length_px;
  EXPECT_NE(contradictionOf(info).find("focal length"), std::string::npos);
  info = infoOf(1280, 960);
  info.binning_x = info.binning_y = 2;
  info.K[0] = 2.0 * focal_length_px;
  EXPECT_EQ(contradictionOf(info), "");
  info.K[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(contradictionOf(info), "");
}

}  // namespace
}  // namespace bearing_calibration_ros
