#pragma once

#include <cstddef>

#include "bearing_calibration/init/initializer.h"

namespace bearing_calibration::core {

/// Whether the residuals are as large as their noise, and most observations are in use.
bool fitsWell(const BatchEstimate& batch, const InitializerConfig& config);

/// What the motion alone rules out.
StartObstacle motionObstacle(std::size_t observations, const MotionSummary& motion,
                             const InitializerConfig& config);

/// What the answer itself lacks.
StartObstacle answerObstacle(const StartAttempt& attempt, const BatchEstimate& batch,
                             const InitializerConfig& config);

}  // namespace bearing_calibration::core
