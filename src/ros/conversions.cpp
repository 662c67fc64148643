#include "bearing_calibration_ros/conversions.h"

#include <tf2/LinearMath/Quaternion.h>
#include <tf2_geometry_msgs/tf2_geometry_msgs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "bearing_calibration/output/quality.h"

namespace bearing_calibration_ros {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Of light and mount with the errors of clock and wheels, in the message's order.
constexpr int kWithWheels = 5 + core::kWheelErrors;
constexpr std::array<int, kWithWheels> kPlacesWithWheels = {7, 8, 0, 1, 2, 3, 4, 5, 6};
using MatrixWithWheels = Eigen::Matrix<double, kWithWheels, kWithWheels, Eigen::RowMajor>;
static_assert(sizeof(MatrixWithWheels) ==
              sizeof(msg::CalibrationEstimate::_covariance_with_clock_and_wheels_type));

/// Row-major, as messages want it, whatever the matrix is stored like.
template <typename Matrix, typename Array>
void fillRowMajor(const Matrix& matrix, Array* array) {
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      (*array)[static_cast<std::size_t>(row * matrix.cols() + column)] = matrix(row, column);
    }
  }
}

std::optional<double> positionOf(const std::string& joint, const sensor_msgs::JointState& message) {
  const auto found = std::find(message.name.begin(), message.name.end(), joint);
  const auto index = static_cast<std::size_t>(found - message.name.begin());
  if (found == message.name.end() || index >= message.position.size()) return std::nullopt;
  return message.position[index];
}

void appendCount(const std::string& reason, std::uint32_t count, std::string* text) {
  if (count == 0) return;
  if (!text->empty()) *text += "; ";
  *text += reason + ": " + std::to_string(count);
}

void appendCounts(const std::string& stream, const core::InputCounts& counts, std::string* text) {
  for (std::size_t i = 0; i < core::kInputStatusCount; ++i) {
    const auto status = static_cast<core::InputStatus>(i);
    if (!core::InputOutcome{status, 0.0}.isWorthAWord()) continue;
    appendCount(stream + " " + core::nameOf(status), counts[status], text);
  }
}

void fillMount(const std::optional<core::MountEstimate>& estimate,
               msg::CalibrationEstimate* message) {
  const core::MountEstimate none{Eigen::Vector3d::Constant(kNone),
                                 Eigen::Matrix3d::Constant(kNone)};
  const core::MountEstimate& mount = estimate ? *estimate : none;
  message->x_m = mount.mean.x();
  message->y_m = mount.mean.y();
  message->yaw_rad = mount.mean.z();
  message->x_stddev_m = std::sqrt(mount.covariance(0, 0));
  message->y_stddev_m = std::sqrt(mount.covariance(1, 1));
  message->yaw_stddev_rad = std::sqrt(mount.covariance(2, 2));
  fillRowMajor(mount.covariance, &message->covariance_x_y_yaw);
}

void fillCartesianState(const std::optional<core::CartesianEstimate>& estimate,
                        msg::CalibrationEstimate* message) {
  const core::CartesianEstimate none{core::Vector5::Constant(kNone),
                                     core::Matrix5::Constant(kNone)};
  const core::CartesianEstimate& cartesian = estimate ? *estimate : none;
  message->light_x_m = cartesian.lightInBase().x();
  message->light_y_m = cartesian.lightInBase().y();
}

void fillPaperState(const std::optional<core::PaperEstimate>& estimate,
                    msg::CalibrationEstimate* message) {
  const core::PaperEstimate none{core::Vector5::Constant(kNone), core::Matrix5::Constant(kNone),
                                 false};
  const core::PaperEstimate& paper = estimate ? *estimate : none;
  message->D_m = paper.mean(core::PaperIndex::kDistance);
  message->theta_rad = paper.mean(core::PaperIndex::kTheta);
  message->phi_rad = paper.mean(core::PaperIndex::kPhi);
  message->rho_m = paper.mean(core::PaperIndex::kRho);
  message->psi_rad = paper.mean(core::PaperIndex::kPsi);
  message->phi_psi_determined = paper.phi_psi_determined;
  fillRowMajor(paper.covariance, &message->covariance_D_theta_phi_rho_psi);
}

/// The robot's errors, then the levels of the noise.
void fillRobotErrors(const core::CalibrationResult& result, msg::CalibrationEstimate* message) {
  MatrixWithWheels covariance = MatrixWithWheels::Constant(kNone);
  if (result.estimate) {
    covariance = core::partOf(*result.estimate, core::kWheelErrors, {0})
                     .covariance(kPlacesWithWheels, kPlacesWithWheels);
  }
  fillRowMajor(covariance, &message->covariance_with_clock_and_wheels);
  for (const core::BlockReport& report : core::reportErrors(result)) {
    if (report.status == core::BlockStatus::kOff) continue;
    for (const core::ReportedNumber& number : report.numbers) {
      msg::RobotError error;
      error.name = number.quantity.name;
      error.value = number.value;
      error.stddev = number.stddev;
      error.unit = number.quantity.unit;
      error.state = static_cast<std::uint8_t>(report.status);
      message->robot_errors.push_back(error);
    }
  }
}

/// The errors of clock and wheels, by their names; zero where one is not looked for.
Eigen::Matrix<double, core::kWheelErrors, 1> wheelErrorsFrom(
    const std::vector<msg::RobotError>& errors) {
  Eigen::Matrix<double, core::kWheelErrors, 1> values;
  for (int i = 0; i < core::kWheelErrors; ++i) {
    const char* name = core::errorQuantities()[static_cast<std::size_t>(i)].name;
    const auto error = std::find_if(errors.begin(), errors.end(),
                                    [name](const auto& each) { return each.name == name; });
    values(i) = error == errors.end() ? 0.0 : error->value;
  }
  return values;
}

msg::CalibrationLight messageFromLight(const core::LightSummary& light) {
  msg::CalibrationLight message;
  message.light_id = light.light_id;
  const auto& estimate = light.cartesian_state;
  message.x_m = estimate ? estimate->lightInBase().x() : kNone;
  message.y_m = estimate ? estimate->lightInBase().y() : kNone;
  const Eigen::Matrix2d covariance = estimate ? estimate->covariance.topLeftCorner<2, 2>().eval()
                                              : Eigen::Matrix2d::Constant(kNone);
  fillRowMajor(covariance, &message.covariance_x_y);
  message.in_estimate = light.in_estimate;
  message.bearings_used = light.bearings_used;
  message.note = light.note;
  return message;
}

}  // namespace

core::Stamp stampFromRos(const ros::Time& time) {
  constexpr std::int64_t kNanosecondsPerSecond = 1000000000;
  return core::stampFromNanoseconds(static_cast<std::int64_t>(time.sec) * kNanosecondsPerSecond +
                                    static_cast<std::int64_t>(time.nsec));
}

ros::Time rosFromStamp(core::Stamp stamp) {
  constexpr std::int64_t kNanosecondsPerSecond = 1000000000;
  const std::int64_t nanoseconds = stamp.time_since_epoch().count();
  const std::int64_t seconds = nanoseconds / kNanosecondsPerSecond;
  if (nanoseconds < 0 || seconds > std::numeric_limits<std::uint32_t>::max()) {
    throw std::invalid_argument("stamp " + std::to_string(core::secondsFromStamp(stamp)) +
                                " s does not fit into ros::Time");
  }
  return {static_cast<std::uint32_t>(seconds),
          static_cast<std::uint32_t>(nanoseconds % kNanosecondsPerSecond)};
}

core::WheelCounts countsFromMessage(const msg::WheelTicks& message) {
  return {stampFromRos(message.header.stamp), message.left, message.right};
}

std::optional<core::WheelAngles> anglesFromMessage(const sensor_msgs::JointState& message,
                                                   const WheelJoints& joints) {
  const std::optional<double> left = positionOf(joints.left, message);
  const std::optional<double> right = positionOf(joints.right, message);
  if (!left || !right) return std::nullopt;
  return core::WheelAngles{stampFromRos(message.header.stamp), *left, *right};
}

bool namesEither(const sensor_msgs::JointState& message, const WheelJoints& joints) {
  return std::any_of(message.name.begin(), message.name.end(), [&](const std::string& name) {
    return name == joints.left || name == joints.right;
  });
}

std::string jointNames(const sensor_msgs::JointState& message) {
  std::string names;
  for (const std::string& name : message.name) names += (names.empty() ? "" : ", ") + name;
  return names;
}

core::BearingSet bearingsFromMessage(const msg::LightBearings& message) {
  core::BearingSet bearings;
  bearings.stamp = stampFromRos(message.header.stamp);
  const auto said = [](double value) { return std::isnan(value) ? 0.0 : value; };
  bearings.geometry = {said(message.harmonic_stddev), said(message.near_per_far),
                       said(message.nearness_stddev)};
  bearings.candidates.reserve(message.candidates.size());
  for (const msg::LightBearing& candidate : message.candidates) {
    core::Bearing bearing;
    bearing.azimuth_rad = candidate.azimuth;
    bearing.azimuth_variance_rad2 = candidate.azimuth_variance;
    bearing.image_radius_px = candidate.image_radius;
    bearing.image_radius_variance_px2 = candidate.image_radius_variance;
    bearing.elevation_rad = candidate.elevation;
    bearing.elevation_variance_rad2 = candidate.elevation_variance;
    bearing.light_id = candidate.light_id;
    bearing.probability = static_cast<double>(candidate.probability);
    bearings.candidates.push_back(bearing);
  }
  return bearings;
}

msg::PredictedBearing messageFromPrediction(const core::BearingPrediction& prediction,
                                            const std::string& sensor_frame) {
  msg::PredictedBearing message;
  message.header.stamp = rosFromStamp(prediction.stamp);
  message.header.frame_id = sensor_frame;
  message.azimuth = prediction.azimuth_rad;
  message.azimuth_variance = prediction.azimuth_variance_rad2;
  message.light_id = prediction.light_id;
  return message;
}

std::string rejectionsText(const core::CalibrationResult& result,
                           std::uint32_t joint_states_without_wheels) {
  std::string text;
  appendCounts("ticks", result.tick_inputs, &text);
  appendCounts("bearings", result.bearing_inputs, &text);
  appendCount("joint states without the wheels", joint_states_without_wheels, &text);
  return text;
}

msg::CalibrationEstimate messageFromResult(const core::CalibrationResult& result,
                                           std::uint32_t joint_states_without_wheels,
                                           const std::string& base_frame) {
  msg::CalibrationEstimate message;
  message.header.stamp = rosFromStamp(result.stamp);
  message.header.frame_id = base_frame;
  message.state = static_cast<std::uint8_t>(result.state);
  message.state_text = core::nameOf(result.state);
  message.advice = result.advice;
  message.cause = static_cast<std::uint8_t>(result.cause);
  if (result.cause != core::Fault::kNone) message.cause_text = core::nameOf(result.cause);
  fillMount(result.base_from_sensor, &message);
  message.quality = core::qualityInWords(result);
  fillCartesianState(result.cartesian_state, &message);
  fillPaperState(result.paper_state, &message);
  fillRobotErrors(result, &message);
  if (result.lights.size() > 1) {
    for (const core::LightSummary& light : result.lights) {
      message.lights.push_back(messageFromLight(light));
    }
  }
  message.nis_mean = result.nis_mean;
  message.distance_travelled_m = result.distance_travelled_m;
  message.rotation_travelled_rad = result.rotation_travelled_rad;
  message.bearings_used = result.bearings_used;
  message.bearings_gated = result.bearings_gated;
  message.bearings_waiting = result.bearings_waiting;
  message.bearings_rejected = result.bearing_inputs.badInputs();
  message.ticks_used = result.ticks_used;
  message.ticks_rejected = result.tick_inputs.badInputs() + joint_states_without_wheels;
  message.rejections = rejectionsText(result, joint_states_without_wheels);
  return message;
}

std::optional<core::StateEstimate> robotFromMessage(const msg::CalibrationEstimate& message) {
  core::StateEstimate estimate = core::StateEstimate::zero({core::kWheelErrors, 1});
  estimate.mean << message.x_m, message.y_m, message.yaw_rad, wheelErrorsFrom(message.robot_errors),
      message.light_x_m, message.light_y_m;
  estimate.covariance(kPlacesWithWheels, kPlacesWithWheels) =
      Eigen::Map<const MatrixWithWheels>(message.covariance_with_clock_and_wheels.data());
  if (!estimate.mean.allFinite() || !estimate.covariance.allFinite()) return std::nullopt;
  return estimate;
}

geometry_msgs::Pose poseFromPlane(const core::Pose2& pose, double z_m) {
  geometry_msgs::Pose message;
  message.position.x = pose.position_m.x();
  message.position.y = pose.position_m.y();
  message.position.z = z_m;
  tf2::Quaternion orientation;
  orientation.setRPY(0.0, 0.0, pose.yaw_rad);
  message.orientation = tf2::toMsg(orientation);
  return message;
}

geometry_msgs::TransformStamped transformFromPlane(const core::Pose2& parent_from_child,
                                                   core::Stamp stamp,
                                                   const std::string& parent_frame,
                                                   const std::string& child_frame) {
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header.stamp = rosFromStamp(stamp);
  pose.header.frame_id = parent_frame;
  pose.pose.pose = poseFromPlane(parent_from_child);
  return transformFromPose(pose, child_frame);
}

geometry_msgs::PoseWithCovarianceStamped poseFromMount(const core::MountEstimate& base_from_sensor,
                                                       const core::UnestimatedMount& unestimated,
                                                       core::Stamp stamp,
                                                       const std::string& base_frame) {
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header.stamp = rosFromStamp(stamp);
  pose.header.frame_id = base_frame;
  pose.pose.pose.position.x = base_from_sensor.mean.x();
  pose.pose.pose.position.y = base_from_sensor.mean.y();
  pose.pose.pose.position.z = unestimated.z_m;
  tf2::Quaternion orientation;
  orientation.setRPY(unestimated.roll_rad, unestimated.pitch_rad, base_from_sensor.mean.z());
  pose.pose.pose.orientation = tf2::toMsg(orientation);

  enum Axis : int { kX, kY, kZ, kRoll, kPitch, kYaw };  // REP 103
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  const std::array<int, 3> estimated{kX, kY, kYaw};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      covariance(estimated.at(static_cast<std::size_t>(i)),
                 estimated.at(static_cast<std::size_t>(j))) = base_from_sensor.covariance(i, j);
    }
  }
  covariance(kZ, kZ) = std::pow(unestimated.z_stddev_m, 2);
  covariance(kRoll, kRoll) = std::pow(unestimated.roll_stddev_rad, 2);
  covariance(kPitch, kPitch) = std::pow(unestimated.pitch_stddev_rad, 2);
  fillRowMajor(covariance, &pose.pose.covariance);
  return pose;
}

geometry_msgs::TransformStamped transformFromPose(
    const geometry_msgs::PoseWithCovarianceStamped& base_from_sensor,
    const std::string& sensor_frame) {
  geometry_msgs::TransformStamped transform;
  transform.header = base_from_sensor.header;
  transform.child_frame_id = sensor_frame;
  transform.transform.translation.x = base_from_sensor.pose.pose.position.x;
  transform.transform.translation.y = base_from_sensor.pose.pose.position.y;
  transform.transform.translation.z = base_from_sensor.pose.pose.position.z;
  transform.transform.rotation = base_from_sensor.pose.pose.orientation;
  return transform;
}

}  // namespace bearing_calibration_ros
