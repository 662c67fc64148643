#include "support/synthetic_spot.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "support/default_rig.h"

namespace bearing_calibration::core {
namespace test {

cv::Mat flatImage(int width_px, int height_px, double background_levels) {
  return cv::Mat(height_px, width_px, CV_64FC1, cv::Scalar(background_levels));
}

void addSpot(cv::Mat* expected_levels, const SpotDrawing& spot) {
  constexpr int kLines = 64;  // in a pixel's height; along a line the overlap is exact
  const double c = std::cos(spot.major_angle_rad);
  const double s = std::sin(spot.major_angle_rad);
  const double a2 = std::pow(0.5 * spot.major_diameter_px, 2);
  const double b2 = std::pow(0.5 * spot.minor_diameter_px, 2);
  // The ellipse is uu du^2 + 2 uv du dv + vv dv^2 <= 1.
  const double uu = c * c / a2 + s * s / b2;
  const double uv = c * s * (1.0 / a2 - 1.0 / b2);
  const double vv = s * s / a2 + c * c / b2;
  const double half_height = std::sqrt(uu / (uu * vv - uv * uv));
  const auto lineOf = [&](double v) { return static_cast<int>(std::floor((v + 0.5) * kLines)); };
  for (int line = lineOf(spot.centre_px.y() - half_height);
       line <= lineOf(spot.centre_px.y() + half_height); ++line) {
    const int v = static_cast<int>(std::floor(static_cast<double>(line) / kLines));
    if (v < 0 || v >= expected_levels->rows) continue;
    const double dv = (line + 0.5) / kLines - 0.5 - spot.centre_px.y();
    const double root2 = uv * uv * dv * dv - uu * (vv * dv * dv - 1.0);
    if (root2 <= 0.0) continue;
    const double first = spot.centre_px.x() + (-uv * dv - std::sqrt(root2)) / uu;
    const double last = spot.centre_px.x() + (-uv * dv + std::sqrt(root2)) / uu;
    for (int u = std::max(0, static_cast<int>(std::floor(first)));
         u <= std::min(expected_levels->cols - 1, static_cast<int>(std::ceil(last))); ++u) {
      const double overlap = std::min(last, u + 0.5) - std::max(first, u - 0.5);
      expected_levels->at<double>(v, u) += spot.light_levels * std::max(0.0, overlap) / kLines;
    }
  }
}

SpotDrawing spotOfLight(const DetectorConfig& config, const LightPlace& light, double azimuth_rad,
                        double light_levels) {
  const double radius_px = radiusFromLight(config.mirror, light).value();
  const SpotBlur blur = expectedBlur(config.mirror, radius_px, light.distance_m);
  SpotDrawing spot;
  spot.centre_px = imageFromMirrorPixel(config.view, {radius_px, azimuth_rad});
  const Eigen::Vector2d from_centre =
      spot.centre_px - Eigen::Vector2d(config.view.centre_u_px, config.view.centre_v_px);
  spot.major_angle_rad = std::atan2(from_centre.y(), from_centre.x());
  spot.major_diameter_px = blur.radial_diameter_px;
  spot.minor_diameter_px = blur.tangential_diameter_px;
  spot.light_levels = light_levels;
  return spot;
}

cv::Mat expose(const cv::Mat& expected_levels, const ImageSensor& sensor, std::mt19937* random) {
  std::normal_distribution<double> normal;
  cv::Mat image(expected_levels.size(), CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double electrons = expected_levels.at<double>(v, u) * sensor.electrons_per_level;
      // The normal limit of the Poisson distribution: hundreds of electrons in every lit pixel.
      const double deviation =
          std::sqrt(std::max(0.0, electrons) + std::pow(sensor.read_noise_electrons, 2));
      const double level = (electrons + deviation * normal(*random)) / sensor.electrons_per_level;
      image.at<std::uint8_t>(v, u) =
          static_cast<std::uint8_t>(std::clamp(std::round(level), 0.0, sensor.saturation_level));
    }
  }
  return image;
}

double azimuthBound(const DetectorConfig& config, const SpotDrawing& spot,
                    double background_levels) {
  const int width = config.sensor.width_px;
  const int height = config.sensor.height_px;
  const auto draw = [&](const Eigen::Vector2d& shift) {
    SpotDrawing moved = spot;
    moved.centre_px += shift;
    cv::Mat image = flatImage(width, height, background_levels);
    addSpot(&image, moved);
    return image;
  };
  constexpr double kStep_px = 0.25;  // many sub-samples wide
  const cv::Mat mean = draw(Eigen::Vector2d::Zero());
  const cv::Mat du = (draw({kStep_px, 0.0}) - draw({-kStep_px, 0.0})) / (2.0 * kStep_px);
  const cv::Mat dv = (draw({0.0, kStep_px}) - draw({0.0, -kStep_px})) / (2.0 * kStep_px);
  const double g = config.sensor.electrons_per_level;
  const double read2 = std::pow(config.sensor.read_noise_electrons / g, 2) + 1.0 / 12.0;
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  const int reach = static_cast<int>(2.0 * spot.major_diameter_px);
  for (int v = std::max(0, static_cast<int>(spot.centre_px.y()) - reach);
       v < std::min(height, static_cast<int>(spot.centre_px.y()) + reach); ++v) {
    for (int u = std::max(0, static_cast<int>(spot.centre_px.x()) - reach);
         u < std::min(width, static_cast<int>(spot.centre_px.x()) + reach); ++u) {
      const double level = mean.at<double>(v, u);
      const Eigen::Vector4d row(du.at<double>(v, u), dv.at<double>(v, u),
                                (level - background_levels) / spot.light_levels, 1.0);
      information += row * row.transpose() / (level / g + read2);
    }
  }
  const Eigen::Matrix2d covariance = information.inverse().topLeftCorner<2, 2>();
  const Eigen::Vector2d from_centre =
      spot.centre_px - Eigen::Vector2d(config.view.centre_u_px, config.view.centre_v_px);
  const Eigen::Vector2d tangent =
      Eigen::Vector2d(-from_centre.y(), from_centre.x()) / from_centre.squaredNorm();
  return tangent.dot(covariance * tangent);
}

DetectorConfig shippedDetector() {
  DetectorConfig config;
  config.mirror = defaultMirror();
  config.optics_stddev = {0.04, 0.25, 0.15, 0.026};
  config.view = {319.5, 239.5, -1};
  config.sensor.width_px = 640;
  config.sensor.height_px = 480;
  config.sensor.electrons_per_level = 12000.0 / 255.0;
  config.sensor.saturation_level = 255.0;
  config.sensor.read_noise_electrons = 12.0;
  config.mask.inner_radius_px = 40.0;
  config.mask.outer_radius_px = 250.0;
  config.mask.first_row = 0;
  config.mask.last_row = config.sensor.height_px - 1;
  config.threshold.min_contrast_levels = 12.0;
  config.threshold.spreads = 6.0;
  config.light.min_distance_m = 0.25;
  config.light.max_distance_m = 10.0;
  config.light.radius_m = 0.02;
  config.light.half_height_m = 0.02;
  config.light.brightness_spread = 0.3;
  config.light.max_height_m = 0.1;
  config.gates.min_pixels = 4;
  config.gates.max_pixels = 2000;
  config.gates.min_probability = 0.1;
  config.alignment.geometry = {0.03, 0.0, 0.005};
  config.alignment.centre_stddev_px = 0.05;
  config.alignment.elevation_stddev_rad = 0.01;
  config.max_candidates = 100;
  return config;
}

DetectorConfig defaultDetector() {
  DetectorConfig config = shippedDetector();
  config.view.handedness = 1;
  config.threshold.min_contrast_levels = 25.0;
  config.light.radius_m = 0.0;
  config.light.half_height_m = 0.0;
  config.light.brightness_spread = 0.0;
  config.alignment = {};
  return config;
}

}  // namespace test
}  // namespace bearing_calibration::core
