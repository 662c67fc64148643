#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace bearing_calibration::core {
namespace test {

/// A grey picture of the recordings' folder BEARING_CALIBRATION_DATA; empty without it.
inline cv::Mat photograph(const std::string& name) {
  const char* folder = std::getenv("BEARING_CALIBRATION_DATA");
  if (folder == nullptr) return {};
  const cv::Mat image = cv::imread(std::string(folder) + "/images/" + name, cv::IMREAD_GRAYSCALE);
  if (image.empty()) ADD_FAILURE() << "cannot read " << folder << "/images/" << name;
  return image;
}

}  // namespace test
}  // namespace bearing_calibration::core
