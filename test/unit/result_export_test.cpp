#include "bearing_calibration/output/result_export.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <string>

#include "support/some_calibration.h"

namespace bearing_calibration::core {
namespace {

std::string formOf(const std::string& name, const SavedCalibration& saved) {
  for (const FileText& form : formsOf(saved)) {
    if (form.name == name) return form.text;
  }
  ADD_FAILURE() << "there is no " << name;
  return {};
}

/// Written out by hand: R = Rz(yaw) Ry(pitch) Rx(roll), as REP 103 and URDF have it.
Eigen::Matrix4d expectedBaseFromCamera() {
  const double cy = std::cos(0.7), sy = std::sin(0.7);
  const double cp = std::cos(-0.03), sp = std::sin(-0.03);
  const double cr = std::cos(0.02), sr = std::sin(0.02);
  Eigen::Matrix4d T;
  T << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, 0.2,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, -0.1,  //
      -sp, cp * sr, cp * cr, 0.35,                                    //
      0.0, 0.0, 0.0, 1.0;
  return T;
}

TEST(ResultExport, KalibrsMatrixMapsFromTheBaseToTheCamera) {
  const YAML::Node rows =
      YAML::Load(formOf("kalibr_camchain.yaml", someCalibration()))["cam0"]["T_cam_imu"];
  Eigen::Matrix4d camera_from_base;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      camera_from_base(i, j) =
          rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].as<double>();
    }
  }
  EXPECT_TRUE((camera_from_base * expectedBaseFromCamera()).isIdentity(1e-12)) << camera_from_base;
}

TEST(ResultExport, OpenCvReadsTheMatrixFromTheCameraToTheBase) {
  const cv::FileStorage file(formOf("vins_extrinsics.yaml", someCalibration()),
                             cv::FileStorage::READ | cv::FileStorage::MEMORY);
  const cv::Mat base_from_camera = file["body_T_cam0"].mat();
  ASSERT_EQ(base_from_camera.size(), cv::Size(4, 4));
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR(base_from_camera.at<double>(i, j), expectedBaseFromCamera()(i, j), 1e-12);
    }
  }
}

TEST(ResultExport, MultipliersAreOneWhereNothingWasEstimated) {
  SavedCalibration saved = someCalibration();
  saved.result.error_priors.setBlock(WheelSeparation::kName, 0.01);
  saved.result.robot_errors = priorEstimate(saved.result.error_priors);
  saved.result.robot_errors.mean(placeOf<WheelSeparation>()) = 0.02;
  const YAML::Node multipliers = YAML::Load(formOf("diff_drive_controller.yaml", saved));
  EXPECT_DOUBLE_EQ(multipliers["wheel_separation_multiplier"].as<double>(), 1.02);
  EXPECT_EQ(multipliers["left_wheel_radius_multiplier"].as<double>(), 1.0);
  EXPECT_EQ(multipliers["right_wheel_radius_multiplier"].as<std::string>(), "1.0");
}

TEST(ResultExport, LeavesXacrosWordsToXacro) {
  const std::string text = formOf("mount.urdf.xacro", someCalibration());
  for (const char* part :
       {"parent:=base_link child:=camera z:=0.35 roll:=0.02 pitch:=-0.03",
        "<parent link=\"${parent}\"/>", "xyz=\"0.2 -0.1 ${z}\"", "rpy=\"${roll} ${pitch} 0.7\""}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  }
}

TEST(ResultExport, FramesAreEscaped) {
  SavedCalibration saved = someCalibration();
  saved.sensor_frame = "a<b&\"c\"";
  EXPECT_NE(formOf("mount.urdf", saved).find("<child link=\"a&lt;b&amp;&quot;c&quot;\"/>"),
            std::string::npos);
}

// Nobody must find a joint beside a result that is none.
TEST(ResultExport, AnUntrustedResultHasNoForms) {
  SavedCalibration saved = someCalibration();
  EXPECT_EQ(formsOf(saved).size(), 6U);
  saved.result.state = CalibrationState::kInconsistent;
  EXPECT_TRUE(formsOf(saved).empty());
}

}  // namespace
}  // namespace bearing_calibration::core
