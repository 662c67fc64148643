#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "bearing_calibration/geometry/pictures.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/track/association_outcome.h"

namespace bearing_calibration::core {

/// What a picture of a calibration shows, from above. What the robot carries is in the base frame;
/// what stands in the world is in the start frame, the base frame of the first image, where it
/// stands still as far as odometry can tell.
struct Visualisation {
  struct Light {
    Eigen::Vector2d in_start = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> ellipse_in_start;  ///< closed
    bool in_estimate = false;                       ///< the mount rests on it
  };
  struct Found {
    std::vector<Light> lights;  ///< the first one is that of the estimate
    Pose2 base_from_sensor;
    std::vector<Eigen::Vector2d> sensor_ellipse_in_base;  ///< closed
    double sensor_yaw_band_rad = 0.0;  ///< to either side, as wide as the ellipses
  };
  std::optional<Found> found;  ///< none before the first estimate
  /// Of the last fused bearing, from the sensor to a little beyond the light.
  std::optional<std::array<Eigen::Vector2d, 2>> ray_in_start;
  std::vector<Eigen::Vector2d> path_in_start;  ///< of the base's centre
};

/// Draws a calibration as it goes on.
class Visualiser {
 public:
  /// @param sigmas  standard deviations along the axes of the ellipses
  explicit Visualiser(double sigmas);

  void see(const AssociationOutcome& outcome);
  Visualisation draw(const CalibrationResult& result, const Pose2& start_from_base_now);
  /// Everything begins anew, the start frame too.
  void restart();

 private:
  Visualisation::Found drawFound(const CalibrationResult& result) const;
  Visualisation::Light drawLight(const CartesianEstimate& estimate, const Pose2& start_from_base,
                                 bool in_estimate) const;

  double sigmas_;
  DrivenPath path_;
  std::optional<Observation> last_fused_;
  std::optional<std::array<Eigen::Vector2d, 2>> ray_in_start_;
};

}  // namespace bearing_calibration::core
