#include "bearing_calibration/vision/annotation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "bearing_calibration/common/angle.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

const Eigen::Vector2d kCentre_px(450.0, 240.0);
constexpr double kRadius_px = 20.0;

/// Of an evenly filled disc, whose bearing is known so well.
cv::Mat pictureOfALight(double stddev_deg) {
  const DetectorConfig config = test::defaultDetector();
  Detection light;
  light.ellipse.centre_px = kCentre_px;
  light.ellipse.moments_px2 = kRadius_px * kRadius_px / 4.0 * Eigen::Matrix2d::Identity();
  light.bearing.azimuth_variance_rad2 = std::pow(radiansFromDegrees(stddev_deg), 2);
  DetectionResult result;
  result.lights.push_back(light);
  return annotate(cv::Mat::zeros(config.sensor.height_px, config.sensor.width_px, CV_8UC1), result,
                  config);
}

/// The most green of the pixels around a place: a line of one pixel is drawn across several.
int greenAt(const cv::Mat& picture, const Eigen::Vector2d& place_px) {
  int most = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const cv::Point place(cvRound(place_px.x()) + du, cvRound(place_px.y()) + dv);
      most = std::max(most, int{picture.at<cv::Vec3b>(place)[1]});
    }
  }
  return most;
}

TEST(Annotation, OutlinesTheLight) {
  const cv::Mat picture = pictureOfALight(0.1);
  for (double angle_rad : {0.6, 2.0, 3.5, 5.0}) {
    const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
    EXPECT_GT(greenAt(picture, kCentre_px + kRadius_px * direction), 100) << angle_rad;
  }
  const Eigen::Vector2d left(-1.0, 0.0);  // the text is on the right
  EXPECT_EQ(greenAt(picture, kCentre_px + 0.7 * kRadius_px * left), 0);
}

TEST(Annotation, StatesTheDeviationInThousandthsOfADegree) {
  const auto differ = [](double a_deg, double b_deg) {
    return cv::norm(pictureOfALight(a_deg), pictureOfALight(b_deg), cv::NORM_INF) > 0.0;
  };
  EXPECT_TRUE(differ(0.057, 0.069));
  EXPECT_FALSE(differ(0.0571, 0.0574));
}

}  // namespace
}  // namespace bearing_calibration::core
