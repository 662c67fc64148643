#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/record/observation_record.h"

namespace bearing_calibration::core {

/// One light in one image.
struct LightObservation {
  double azimuth_rad = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not seen
  double azimuth_variance_rad2 = std::numeric_limits<double>::quiet_NaN();
  std::optional<Elevation> elevation = std::nullopt;  ///< where the sensor has one

  bool isSeen() const { return !std::isnan(azimuth_rad); }
};

/// What an image showed of several lights, and the base's motion since the image before.
struct LightsImage {
  Stamp stamp;
  OdometryIncrement motion;
  OdometryWindow nearby;  ///< travel around the stamp
  std::array<LightObservation, kMostLights> lights;
};

/// The record that several lights share.
class LightsRecord : public ThinnedRecord<LightsImage> {
 public:
  using ThinnedRecord::ThinnedRecord;

  /// Nothing that was seen of a light so far was that light.
  void forget(std::size_t light) {
    for (LightsImage& image : changeable()) image.lights.at(light) = {};
  }
};

}  // namespace bearing_calibration::core
