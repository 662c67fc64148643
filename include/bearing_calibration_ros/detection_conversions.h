#pragma once

#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/PredictedBearing.h>

#include <string>

#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration_ros {

bearing_calibration::LightBearings messageFromBearings(const bearing_calibration::BearingSet& set,
                                                       const std::string& sensor_frame);

bearing_calibration::BearingPrediction predictionFromMessage(
    const bearing_calibration::PredictedBearing& message);

}  // namespace bearing_calibration_ros
