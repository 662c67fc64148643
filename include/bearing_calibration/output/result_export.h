#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

/// The mount in the forms that other programs take. z, roll and pitch are the configured ones.

/// A URDF with the two frames as links and the fixed joint between them, to copy the joint from.
std::string urdfFrom(const SavedCalibration& calibration);
/// A xacro macro `bearing_calibration_mount` with the joint; its arguments are the frames' names
/// and what was not estimated.
std::string xacroFrom(const SavedCalibration& calibration);
/// A launch file with tf2_ros' static_transform_publisher.
std::string launchFrom(const SavedCalibration& calibration);
/// Kalibr's camchain: T_cam_imu with the base in the place of the IMU (it maps points from the
/// base's frame to the camera's).
std::string kalibrFrom(const SavedCalibration& calibration);
/// body_T_cam0 as VINS-Fusion reads it through cv::FileStorage (from the camera's to the base's).
std::string vinsFrom(const SavedCalibration& calibration);
/// The multipliers of diff_drive_controller: the estimated blocks over the configured values, 1 for
/// what was not estimated.
std::string diffDriveFrom(const SavedCalibration& calibration);

/// All forms as the files that lie beside result.yaml: mount.urdf, mount.urdf.xacro,
/// static_transform.launch, kalibr_camchain.yaml, vins_extrinsics.yaml, diff_drive_controller.yaml.
/// None where the result may not be trusted: nobody shall find a joint of it.
std::vector<FileText> formsOf(const SavedCalibration& calibration);

}  // namespace bearing_calibration::core
