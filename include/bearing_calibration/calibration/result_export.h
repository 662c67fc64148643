#pragma once

#include <optional>
#include <string>

#include "bearing_calibration/calibration/result_file.h"

namespace bearing_calibration {

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

/// Writes `folder`/result.yaml, and the forms above beside it where the result may be trusted
/// (converged or converging): mount.urdf, mount.urdf.xacro, static_transform.launch,
/// kalibr_camchain.yaml, vins_extrinsics.yaml, diff_drive_controller.yaml. Where it may not, forms
/// of an earlier result are removed, so that nobody takes them for this one's.
/// @returns what went wrong; nothing when all is written.
std::optional<std::string> writeResultFolder(const std::string& folder,
                                             const SavedCalibration& calibration);

/// Removes what writeResultFolder() writes.
void removeResultFolder(const std::string& folder);

}  // namespace bearing_calibration
