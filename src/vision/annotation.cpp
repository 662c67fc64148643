#include "bearing_calibration/vision/annotation.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

const cv::Scalar kAccepted(0, 220, 0);  // blue, green, red
const cv::Scalar kRejected(40, 40, 255);
const cv::Scalar kMask(255, 120, 0);

cv::Point pointOf(const Eigen::Vector2d& position_px) {
  return {cvRound(position_px.x()), cvRound(position_px.y())};
}

void write(cv::Mat* picture, const std::string& text, const cv::Point& beside,
           const cv::Scalar& colour) {
  constexpr double kTextScale = 0.4;
  constexpr int kGap_px = 14;
  cv::putText(*picture, text, beside + cv::Point(kGap_px, -kGap_px), cv::FONT_HERSHEY_SIMPLEX,
              kTextScale, colour, 1, cv::LINE_AA);
}

void drawMask(cv::Mat* picture, const DetectorConfig& config) {
  if (config.mirror_kind == MirrorKind::kNone) return;
  const cv::Point centre = pointOf(config.view.centre_px());
  cv::circle(*picture, centre, cvRound(config.mask.inner_radius_px), kMask);
  cv::circle(*picture, centre, cvRound(config.mask.outer_radius_px), kMask);
  cv::drawMarker(*picture, centre, kMask);
  if (config.mirror_kind == MirrorKind::kCone) {
    cv::circle(*picture, centre, cvRound(largestLightRadiusPx(config)), kMask, 1, cv::LINE_AA);
  }
  for (const MirrorPost& post : config.mask.posts) {
    for (double side : {-1.0, 1.0}) {
      const double azimuth_rad = post.azimuth_rad + side * post.half_width_rad;
      const auto at = [&](double radius_px) {
        return pointOf(imageFromMirrorPixel(config.view, {radius_px, azimuth_rad}));
      };
      cv::line(*picture, at(config.mask.inner_radius_px), at(config.mask.outer_radius_px), kMask);
    }
  }
}

void drawLight(cv::Mat* picture, const Detection& light, const DetectorConfig& config) {
  const LightEllipse& ellipse = light.ellipse;
  constexpr double kDegreesPerTurn = 360.0;
  const Eigen::Vector2d from_centre = ellipse.centre_px - config.view.centre_px();
  const double radius_angle_deg = degreesFromRadians(std::atan2(from_centre.y(), from_centre.x()));
  // An evenly filled ellipse ends at two standard deviations.
  const Eigen::Array2d half_px = 2.0 * ellipse.variances_px2().array().sqrt();
  const cv::Size half_axes(cvRound(half_px(1)), cvRound(half_px(0)));
  const cv::Point centre = pointOf(ellipse.centre_px);
  cv::ellipse(*picture, centre, half_axes, radius_angle_deg, 0.0, kDegreesPerTurn, kAccepted, 1,
              cv::LINE_AA);
  write(
      picture,
      formatted("%.2f +- %.3f deg, probability %.2f", degreesFromRadians(light.bearing.azimuth_rad),
                degreesFromRadians(std::sqrt(light.bearing.azimuth_variance_rad2)),
                light.bearing.probability),
      centre, kAccepted);
}

cv::Mat inColour(const cv::Mat& image, double full_level) {
  constexpr double kFullOnScreen = 255.0;
  cv::Mat grey;
  cv::Mat picture;
  image.convertTo(grey, CV_8U, kFullOnScreen / full_level);
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
  return picture;
}

}  // namespace

cv::Mat annotate(const cv::Mat& image, const DetectionResult& result,
                 const DetectorConfig& config) {
  cv::Mat picture = inColour(image, config.sensor.saturation_level);
  drawMask(&picture, config);
  constexpr int kMarker_px = 10;
  for (const Detection& spot : result.rejected) {
    const cv::Point centre = pointOf(spot.ellipse.centre_px);
    cv::drawMarker(picture, centre, kRejected, cv::MARKER_TILTED_CROSS, kMarker_px);
    write(&picture, describe(spot.rejection), centre, kRejected);
  }
  for (const Detection& light : result.lights) drawLight(&picture, light, config);
  return picture;
}

cv::Mat annotateRim(const cv::Mat& image, const MirrorRim& rim) {
  const bool eight_bits = image.depth() == CV_8U;
  const double full = eight_bits ? std::numeric_limits<std::uint8_t>::max()
                                 : std::numeric_limits<std::uint16_t>::max();
  cv::Mat picture = inColour(image, full);
  constexpr int kDot_px = 2;
  for (const Eigen::Vector2d& place : rim.points_px) {
    cv::circle(picture, pointOf(place), kDot_px, kRejected, cv::FILLED, cv::LINE_AA);
  }
  const cv::Point centre = pointOf(rim.circle.centre_px);
  cv::circle(picture, centre, cvRound(rim.circle.radius_px), kAccepted, 1, cv::LINE_AA);
  cv::drawMarker(picture, centre, kAccepted);
  return picture;
}

}  // namespace bearing_calibration::core
