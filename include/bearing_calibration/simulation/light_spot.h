#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "bearing_calibration/simulation/cone_tracer.h"
#include "bearing_calibration/simulation/shutter.h"

namespace bearing_calibration::core {

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

  /// Where the ball is in the sensor frame at a time.
  using BallPath = std::function<LuminousBall(double time_s)>;
  /// The same for a ball that moves while the rows of the image are exposed one after another:
  /// each ray has a time of its own within the exposure of the row that it lights. (An image that
  /// runs along with the read-out is exposed longer, by less than a percent: left out.)
  void traceMoving(const ConeTracer& tracer, const BallPath& path, const Shutter& shutter,
                   const RayVisitor& visit) const;
  /// The moment at which the row that the ball's image is in is exposed, and that image (the ray
  /// through the middle of the lens); none when the mirror does not show it.
  struct RowExposure {
    double time_s = 0.0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  static std::optional<RowExposure> rowExposureOf(const ConeTracer& tracer, const BallPath& path,
                                                  const Shutter& shutter);

  SpotMoments moments(const ConeTracer& tracer, const LuminousBall& light) const;

  /// Adds the light to an image of `width_px` columns; each ray lights one pixel's area, shared out
  /// among the four pixels that it covers.
  void addTo(const ConeTracer& tracer, const LuminousBall& light, double electrons_per_flux,
             std::vector<float>* electrons) const;
  void addMovingTo(const ConeTracer& tracer, const BallPath& path, const Shutter& shutter,
                   double electrons_per_flux, std::vector<float>* electrons) const;

 private:
  struct Sample {
    Eigen::Vector2d aperture_m;
    Eigen::Vector2d ball;  ///< in the unit disc, across the line of sight
    double moment;         ///< of the exposure, -0.5 to 0.5
  };
  static Eigen::Vector3d sourceOf(const Sample& sample, const LuminousBall& light);
  std::vector<Sample> samples_;
  double area_per_ray_m2_;
};

}  // namespace bearing_calibration::core
