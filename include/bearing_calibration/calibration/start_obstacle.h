#pragma once

#include <cstddef>

#include "bearing_calibration/calibration/initializer.h"

namespace bearing_calibration {

/// Whether the residuals are as large as their noise, and most sights are in use.
bool fitsWell(const BatchEstimate& batch, const InitializerConfig& config);

/// What the motion alone rules out.
StartObstacle motionObstacle(std::size_t sights, const MotionSummary& motion,
                             const InitializerConfig& config);

/// What the answer itself lacks.
StartObstacle answerObstacle(const StartAttempt& attempt, const BatchEstimate& batch,
                             const InitializerConfig& config);

}  // namespace bearing_calibration
