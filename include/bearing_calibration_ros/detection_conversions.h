#pragma once

#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/PredictedBearing.h>

#include <string>

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

msg::LightBearings messageFromBearings(const core::BearingSet& set,
                                       const std::string& sensor_frame);

core::BearingPrediction predictionFromMessage(const msg::PredictedBearing& message);

}  // namespace bearing_calibration_ros
