#pragma once

#include <vector>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

/// The mount in the forms that other programs take, as files that lie beside result.yaml; z, roll
/// and pitch are the configured ones:
///
/// - mount.urdf: the two frames as links and the fixed joint between them, to copy the joint from
/// - mount.urdf.xacro: a macro `bearing_calibration_mount` with the joint; its arguments are the
///   frames' names and what was not estimated
/// - static_transform.launch: tf2_ros' static_transform_publisher
/// - kalibr_camchain.yaml: T_cam_imu with the base in the place of the IMU (it maps points from the
///   base's frame to the camera's)
/// - vins_extrinsics.yaml: body_T_cam0 as VINS-Fusion reads it through cv::FileStorage (from the
///   camera's to the base's)
/// - diff_drive_controller.yaml: its multipliers, the estimated blocks over the configured values,
///   1 for what was not estimated
///
/// None where the result may not be trusted: nobody shall find a joint of it.
std::vector<FileText> formsOf(const SavedCalibration& calibration);

}  // namespace bearing_calibration::core
