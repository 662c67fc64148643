#include "bearing_calibration/filter/tilted_observation.h"

#include <cmath>

namespace bearing_calibration::core {
namespace {

/// The light in the frame of the tilted sensor, with its Jacobian by azimuth, range, roll, pitch
/// and height.
struct TiltedLight {
  Eigen::Vector3d in_sensor;
  Eigen::Matrix<double, 3, 5> J_light_level;

  double acrossAxis() const { return in_sensor.head<2>().norm(); }
};

TiltedLight tilted(const LevelObservation& level) {
  const double c = std::cos(level.azimuth_rad);
  const double s = std::sin(level.azimuth_rad);
  const double c_roll = std::cos(level.roll_rad);
  const double s_roll = std::sin(level.roll_rad);
  const double c_pitch = std::cos(level.pitch_rad);
  const double s_pitch = std::sin(level.pitch_rad);
  Eigen::Matrix3d R_level_pitched;
  R_level_pitched << c_pitch, 0.0, s_pitch, 0.0, 1.0, 0.0, -s_pitch, 0.0, c_pitch;
  Eigen::Matrix3d R_pitched_tilted;
  R_pitched_tilted << 1.0, 0.0, 0.0, 0.0, c_roll, -s_roll, 0.0, s_roll, c_roll;
  const Eigen::Matrix3d R_tilted_level = (R_level_pitched * R_pitched_tilted).transpose();
  const Eigen::Vector3d outwards = R_tilted_level * Eigen::Vector3d(c, s, 0.0);
  const Eigen::Vector3d up = R_tilted_level.col(2);

  TiltedLight light;
  light.in_sensor = level.range_m * outwards + level.height_m * up;
  const Eigen::Vector3d pitched = R_pitched_tilted * light.in_sensor;
  light.J_light_level << level.range_m * (R_tilted_level * Eigen::Vector3d(-s, c, 0.0)), outwards,
      Eigen::Vector3d(0.0, light.in_sensor.z(), -light.in_sensor.y()),
      R_pitched_tilted.transpose() * Eigen::Vector3d(-pitched.z(), 0.0, pitched.x()), up;
  return light;
}

}  // namespace

TiltedAngle tiltedAzimuth(const LevelObservation& level) {
  const TiltedLight light = tilted(level);
  const Eigen::Vector3d& in_sensor = light.in_sensor;
  const Eigen::RowVector2d J_azimuth_light =
      Eigen::RowVector2d(-in_sensor.y(), in_sensor.x()) / in_sensor.head<2>().squaredNorm();
  return {std::atan2(in_sensor.y(), in_sensor.x()),
          J_azimuth_light * light.J_light_level.topRows<2>()};
}

TiltedAngle tiltedElevation(const LevelObservation& level) {
  const TiltedLight light = tilted(level);
  const Eigen::Vector3d& in_sensor = light.in_sensor;
  const double across_m = light.acrossAxis();
  Eigen::RowVector3d J_elevation_light;
  J_elevation_light << -in_sensor.z() / across_m * in_sensor.head<2>().transpose(), across_m;
  return {std::atan2(in_sensor.z(), across_m),
          J_elevation_light / in_sensor.squaredNorm() * light.J_light_level};
}

}  // namespace bearing_calibration::core
