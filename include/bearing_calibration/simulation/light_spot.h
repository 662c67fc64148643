#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "bearing_calibration/simulation/cone_tracer.h"

namespace bearing_calibration {

/// A luminous ball in the sensor frame.
struct LuminousBall {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double brightness = 1.0;
  double radius_m = 0.0;
};

/// First and second moments of where a light's rays hit the image sensor.
struct SpotMoments {
  double flux = 0.0;  ///< 0 when no ray arrives; then the rest means nothing
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();

  /// Flux per pixel in the middle of an evenly filled ellipse with these moments.
  double plateau() const;
};

/// Spreads a light's rays evenly over the lens and follows each of them to the image.
class LightSpot {
 public:
  /// @throws std::invalid_argument unless rays > 0.
  LightSpot(const CameraRig& rig, int rays);

  using RayVisitor = std::function<void(const Eigen::Vector2d& pixel, double flux)>;
  /// Calls `visit` for each ray that arrives. Flux is in units of brightness times steradian.
  void trace(const ConeTracer& tracer, const LuminousBall& light, const RayVisitor& visit) const;

  SpotMoments moments(const ConeTracer& tracer, const LuminousBall& light) const;

  /// Adds the light to an image of `width_px` columns; each ray lights one pixel's area, shared out
  /// among the four pixels that it covers.
  void addTo(const ConeTracer& tracer, const LuminousBall& light, double electrons_per_flux,
             std::vector<float>* electrons) const;

 private:
  struct Sample {
    Eigen::Vector2d aperture_m;
    Eigen::Vector2d ball;  ///< in the unit disc, across the line of sight
  };
  std::vector<Sample> samples_;
  double area_per_ray_m2_;
};

}  // namespace bearing_calibration
