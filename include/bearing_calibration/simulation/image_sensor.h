#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

/// When the rows of an image collect light. Time 0 is the middle of the first row's exposure.
struct Shutter {
  double exposure_s = 0.0;  ///< of each row; 0 freezes every motion
  double row_time_s = 0.0;  ///< from one row's exposure to the next one's; 0 is a global shutter

  void declare(Parameters& params);
  bool isInstant() const { return exposure_s <= 0.0 && row_time_s <= 0.0; }
};

/// How the sensor moves during an exposure: steadily, or not at all.
struct SensorMotion {
  Pose2 world_from_sensor;                                 ///< at time 0
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< in the sensor frame
  double turn_radps = 0.0;

  Pose2 poseAt(double time_s) const;
};

/// The steady motion from one pose to the next within `duration_s`.
SensorMotion motionBetween(const Pose2& world_from_start, const Pose2& world_from_end,
                           double duration_s);

/// What an image sensor makes of light.
struct PixelConfig {
  static constexpr double kLargestValue = 255.0;

  double full_well_electrons = 12000.0;
  double read_noise_electrons = 12.0;

  void declare(Parameters& params);
};

/// Values of pixels with these expected photo-electrons: photon (shot) noise and read noise, both
/// Gaussian, then saturation and 8 bits. The same seed and number give the same noise.
std::vector<std::uint8_t> digitize(const std::vector<float>& electrons, const PixelConfig& pixels,
                                   std::uint64_t seed, std::uint64_t image_number);

/// What a camera's driver makes of the sensor's values.
struct ImageEncoding {
  enum class Layout : std::uint8_t {
    kMono8,
    kBayerRggb8,  ///< named after the first pixels of the first two rows, as in sensor_msgs
    kBayerBggr8,
    kBayerGbrg8,
    kBayerGrbg8,
    kBgr8,  ///< interpolated from an rggb mosaic
  };
  Layout layout = Layout::kMono8;
  int jpeg_quality = 0;  ///< 1 to 100: compressed on the way; 0: not
  /// Of a colour sensor's red and blue pixels to white light, against the green ones.
  double red_response = 1.0;
  double blue_response = 1.0;

  void declare(Parameters& params);
  /// Of the sensor's pixel to white light; 1 for a grey sensor.
  double responseAt(int column, int row) const;
};

/// Names of the layouts as in sensor_msgs/image_encodings.h, in the order of the enumeration.
const std::vector<std::string>& layoutNames();

/// The sensor's own values (CV_8UC1) as CV_8UC1, or CV_8UC3 for kBgr8. An image that went through
/// JPEG is given unpacked.
cv::Mat encode(const cv::Mat& values, const ImageEncoding& encoding);

}  // namespace bearing_calibration::core
