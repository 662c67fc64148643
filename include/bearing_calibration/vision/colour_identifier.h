#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detection.h"
#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {

/// The parts (red, green, blue) of a light's sum over the camera's channels; they add up to 1.
using ColourParts = Eigen::Vector3d;

/// A light that is known by its colour as the camera sees it.
struct ColouredLight {
  std::int32_t light_id = 0;
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  ///< red, green, blue in any unit
};

/// How lights are told by their colours. Parameter group `colour`.
struct ColourConfig {
  bool use = false;
  std::vector<ColouredLight> lights;
  double tolerance = 0.0;  ///< largest distance between the parts of two like colours

  void declare(Parameters& params);
};

/// The colours of an image's lights over their surroundings; nothing where one is too dim or too
/// much of it full. Pixels with a full channel are left out: what the others lose by it is the same
/// in each channel.
/// @param bgr CV_8UC3, which is full at 255 or at what is less in the detector's configuration
std::vector<std::optional<ColourParts>> coloursOf(const cv::Mat& bgr,
                                                  const std::vector<Detection>& lights,
                                                  const DetectorConfig& detector);

/// Gives each candidate the light_id of the light with its colour; all others get the probability
/// 0, by their image and their track.
/// @param colours of the set's candidates, in their order
/// @throws std::invalid_argument unless there is one colour for each candidate.
void identifyByColour(const ColourConfig& config,
                      const std::vector<std::optional<ColourParts>>& colours, BearingSet* set);

}  // namespace bearing_calibration::core
