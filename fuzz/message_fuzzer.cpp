// Messages: whatever their fields hold, the core's types hold the same, and what goes back into a
// message is what came.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/result_messages.h"
#include "bearing_calibration_ros/wheel_input.h"
#include "fuzz/byte_reader.h"
#include "fuzz/drawn_result.h"
#include "fuzz/harness.h"
#include "fuzz/result_checks.h"

namespace bearing_calibration::fuzz {
namespace {

namespace ros_side = bearing_calibration_ros;

constexpr std::int64_t kLatest_ns = 4294967295999999999;  // of ros::Time

/// As a driver may fill it in: nanoseconds beyond a second, too.
ros::Time drawTime(ByteReader* bytes) {
  ros::Time time;
  time.sec = static_cast<std::uint32_t>(bytes->bits());
  time.nsec = static_cast<std::uint32_t>(bytes->bits());
  if (bytes->flag()) time.nsec %= 1000000000U;
  return time;
}

/// Two numbers that are the same, or none both.
bool isSame(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

template <typename Message>
std::vector<std::uint8_t> bytesOf(const Message& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(out, message);
  return bytes;
}

bool runBearings(ByteReader* bytes) {
  LightBearings message;
  message.header.stamp = drawTime(bytes);
  message.harmonic_stddev = bytes->finiteNumber();
  message.near_per_far = bytes->finiteNumber();
  message.nearness_stddev = bytes->finiteNumber();
  for (int i = bytes->byte() % 8; i > 0; --i) {
    LightBearing candidate;
    for (double* number :
         {&candidate.azimuth, &candidate.azimuth_variance, &candidate.image_radius,
          &candidate.image_radius_variance, &candidate.elevation, &candidate.elevation_variance}) {
      *number = bytes->anyNumber();
    }
    candidate.light_id = static_cast<std::int32_t>(bytes->bits());
    for (float* number : {&candidate.probability, &candidate.track_probability}) {
      const auto any = static_cast<std::uint32_t>(bytes->bits());
      std::memcpy(number, &any, sizeof(any));
    }
    message.candidates.push_back(candidate);
  }
  message.view_centre = bytes->finiteNumber();
  message.view_width = bytes->finiteNumber();
  const core::BearingSet set = ros_side::bearingsFromMessage(message);
  if (set.stamp.time_since_epoch().count() > kLatest_ns) return false;
  const LightBearings back = ros_side::messageFromBearings(set, "");
  require(ros_side::bearingsFromMessage(back).stamp == set.stamp, "another stamp");
  message.header.stamp = back.header.stamp;
  for (std::size_t i = 0; i < message.candidates.size(); ++i) {  // NaN has many bits
    for (float LightBearing::*number :
         {&LightBearing::probability, &LightBearing::track_probability}) {
      float& sent = message.candidates[i].*number;
      const float returned = back.candidates.at(i).*number;
      if (std::isnan(sent) && std::isnan(returned)) sent = returned;
    }
  }
  require(bytesOf(message) == bytesOf(back), "bearings have changed on their way");
  return true;
}

bool runTicks(ByteReader* bytes) {
  WheelTicks message;
  message.header.stamp = drawTime(bytes);
  message.left = static_cast<std::int64_t>(bytes->bits());
  message.right = static_cast<std::int64_t>(bytes->bits());
  const core::WheelCounts counts = ros_side::countsFromMessage(message);
  require(counts.left_ticks == message.left && counts.right_ticks == message.right,
          "counts have changed on their way");
  return true;
}

bool runJoints(ByteReader* bytes) {
  static constexpr const char* kNames[] = {"left", "right", "", "arm"};
  sensor_msgs::JointState message;
  message.header.stamp = drawTime(bytes);
  for (int i = bytes->byte() % 8; i > 0; --i) message.name.emplace_back(bytes->pick(kNames));
  for (int i = bytes->byte() % 8; i > 0; --i) message.position.push_back(bytes->anyNumber());
  const ros_side::WheelJoints joints{"left", "right"};
  const auto angles = ros_side::anglesFromMessage(message, joints);
  if (!angles) return false;
  require(ros_side::namesEither(message, joints), "angles of joints that are not there");
  const auto isPosition = [&message](double angle) {
    return std::any_of(message.position.begin(), message.position.end(),
                       [angle](double position) { return isSame(position, angle); });
  };
  require(isPosition(angles->left_rad) && isPosition(angles->right_rad), "angles of nothing");
  return true;
}

bool runOdometry(ByteReader* bytes) {
  nav_msgs::Odometry message;
  message.header.stamp = drawTime(bytes);
  geometry_msgs::Pose& pose = message.pose.pose;
  for (double* number : {&pose.position.x, &pose.position.y, &pose.orientation.x,
                         &pose.orientation.y, &pose.orientation.z, &pose.orientation.w}) {
    *number = bytes->flag() ? bytes->anyNumber() : bytes->between(-1.0, 1.0);
  }
  const core::OdometryPose odometry = ros_side::odometryFromMessage(message);
  require(isSame(odometry.start_from_base.position_m.x(), pose.position.x) &&
              isSame(odometry.start_from_base.position_m.y(), pose.position.y),
          "a position has changed on its way");
  require(!(std::abs(odometry.start_from_base.yaw_rad) > core::kPi) &&
              !(odometry.quaternion_norm < 0.0),
          "an orientation is none");
  return std::isfinite(odometry.quaternion_norm);
}

/// A message of a type that nobody knows, whole or cut short.
bool runCount(ByteReader* bytes) {
  static constexpr const char* kTypes[] = {"int8",   "uint8", "int16",  "uint16", "int32",
                                           "uint32", "int64", "uint64", "float32"};
  constexpr std::size_t kMostDefinition = 64;
  std::string definition = bytes->flag() ? "std_msgs/Header header\n" : "";
  definition +=
      bytes->flag() ? bytes->text(kMostDefinition) : std::string(bytes->pick(kTypes)) + " data\n";
  topic_tools::ShapeShifter message;
  message.morph("*", "some_msgs/Count", definition, "");
  constexpr std::size_t kMostBody = 64;
  std::string body(1, static_cast<char>(bytes->byte()));
  body += bytes->text(kMostBody);
  std::vector<std::uint8_t> content(body.begin(), body.end());
  ros::serialization::IStream in(content.data(), static_cast<std::uint32_t>(content.size()));
  message.read(in);
  try {
    ros_side::countFromMessage(message, ros::Time(1, 0));
  } catch (const std::invalid_argument& error) {
    require(std::string(error.what()).find("some_msgs/Count") != std::string::npos,
            "an error does not name the type");
    return false;
  }
  require(ros_side::isWheelCount(definition), "a count of what has none");
  return true;
}

bool runPrediction(ByteReader* bytes) {
  PredictedBearing message;
  message.header.stamp = ros::Time{static_cast<std::uint32_t>(bytes->bits()), bytes->word()};
  message.azimuth = bytes->anyNumber();
  message.azimuth_variance = bytes->anyNumber();
  message.light_id = static_cast<std::int32_t>(bytes->bits());
  const PredictedBearing back =
      ros_side::messageFromPrediction(ros_side::predictionFromMessage(message), "");
  require(bytesOf(message) == bytesOf(back), "a prediction has changed on its way");
  return true;
}

/// What is published of a mount: a rotation, and a covariance.
void requirePose(const core::MountEstimate& mount, const core::UnestimatedMount& unestimated,
                 core::Stamp stamp) {
  const auto pose = ros_side::poseFromMount(mount, unestimated, stamp, "base_link");
  const auto transform = ros_side::transformFromPose(pose.header, pose.pose.pose, "camera");
  const Eigen::Isometry3d base_from_sensor = ros_side::isometryFromMessage(transform.transform);
  require((base_from_sensor.linear() * base_from_sensor.linear().transpose()).isIdentity(1e-9) &&
              base_from_sensor.translation().head<2>() == mount.mean.head<2>(),
          "a mount is published as another one");
  requireCovariance(Eigen::Map<const Eigen::Matrix<double, 6, 6>>(pose.pose.covariance.data()),
                    "a pose that is published");
}

/// What the drive makes of an estimate, as the calibration says it, or with a number of any kind.
bool runEstimate(ByteReader* bytes) {
  const core::SavedCalibration saved = drawResult(bytes);
  core::CalibrationResult result = saved.result;
  result.stamp = core::stampFromNanoseconds(result.stamp.time_since_epoch().count() % kLatest_ns);
  result.error_priors.stddev.setConstant(bytes->between(0.0, 1.0));
  CalibrationEstimate message = ros_side::messageFromResult(result, bytes->byte(), "base_link");
  requirePose(*result.base_from_sensor, saved.unestimated, result.stamp);
  diagnostic_updater::DiagnosticStatusWrapper status;
  ros_side::fillDiagnostics(result, 0, "", bytes->flag(), &status);
  const auto back = ros_side::robotFromMessage(message);
  require(back.has_value(), "an estimate does not come back");
  requireCovariance(back->covariance, "an estimate that comes back");
  message.covariance_with_clock_and_wheels[bytes->byte() % 81] = bytes->anyNumber();
  message.x_m = bytes->anyNumber();
  if (!message.robot_errors.empty()) message.robot_errors.front().value = bytes->anyNumber();
  const auto odd = ros_side::robotFromMessage(message);
  require(!odd || (odd->mean.allFinite() && odd->covariance.allFinite()), "taken, but not finite");
  return true;
}

}  // namespace

bool run(const std::uint8_t* data, std::size_t size) {
  ByteReader bytes(data, size);
  constexpr int kKinds = 7;
  switch (bytes.byte() % kKinds) {
    case 0:
      return runBearings(&bytes);
    case 1:
      return runTicks(&bytes);
    case 2:
      return runJoints(&bytes);
    case 3:
      return runCount(&bytes);
    case 4:
      return runPrediction(&bytes);
    case 5:
      return runEstimate(&bytes);
    default:
      return runOdometry(&bytes);
  }
}

}  // namespace bearing_calibration::fuzz
