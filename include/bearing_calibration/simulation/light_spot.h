#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "bearing_calibration/simulation/camera_rig.h"
#include "bearing_calibration/simulation/image_sensor.h"
#include "bearing_calibration/simulation/light.h"

namespace bearing_calibration::core {

/// First and second moments of where a light's rays hit the image sensor.
struct SpotMoments {
  double flux = 0.0;  ///< 0 when no ray arrives; then the rest means nothing
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();

  /// Flux per pixel in the middle of an evenly filled ellipse with these moments.
  double plateau() const;
};

/// Spreads a light's rays evenly over the lens and follows each of them to the image. Lights are
/// in the sensor frame; flux is in units of brightness times steradian.
class LightSpot {
 public:
  /// @throws std::invalid_argument with what errorsOf() says, and unless rays > 0.
  LightSpot(const CameraRig& rig, int rays);

  const ConeTracer& tracer() const { return tracer_; }

  /// Of a light that stands still.
  SpotMoments moments(const Light& light) const;

  /// Where a light is at a time.
  using LightPath = std::function<Light(double time_s)>;
  /// Adds a light to an image while its rows are exposed one after another: each ray has a time of
  /// its own within the exposure of the row that it lights, and lights one pixel's area, shared out
  /// among the four pixels that it covers. (An image that runs along with the read-out is exposed
  /// longer, by less than a percent: left out.)
  void addTo(const LightPath& path, const Shutter& shutter, double electrons_per_flux,
             std::vector<float>* electrons) const;

  /// The moment at which the row that the light's image is in is exposed, and that image (the ray
  /// through the middle of the lens); none when the mirror does not show it.
  struct RowExposure {
    double time_s = 0.0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  std::optional<RowExposure> rowExposureOf(const LightPath& path, const Shutter& shutter) const;

 private:
  struct Sample {
    Eigen::Vector2d aperture_m;
    Eigen::Vector2d ball;  ///< in the unit disc, across the line of sight
    double moment;         ///< of the exposure, -0.5 to 0.5
  };
  using RayVisitor = std::function<void(const Eigen::Vector2d& pixel, double flux)>;
  /// Calls `visit` for each ray that arrives.
  void trace(const LightPath& path, const Shutter& shutter, const RayVisitor& visit) const;

  ConeTracer tracer_;
  std::vector<Sample> samples_;
  double area_per_ray_m2_;
};

}  // namespace bearing_calibration::core
