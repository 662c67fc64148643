#pragma once

#include <cstddef>

#include "bearing_calibration/init/initializer.h"

namespace bearing_calibration::core {

/// When a start may be trusted: the estimate must be well inside the range where a linearised
/// filter carries on from it.
struct StartLimits {
  static constexpr std::size_t kMinObservations = 20;
  /// Of the path, which noise alone does not make: enough for any robot.
  static constexpr double kMinExtent_m = 0.4;
  /// A smaller one is enough, too, where it is so many times what the wheels' noise makes: a random
  /// walk's is 2.3, and hardly ever above 4.5; and so much of the light's distance.
  static constexpr double kMinExtentPerNoise = 5.0;
  static constexpr double kMinExtentPerRange = 0.1;
  static constexpr double kMinPathPerRange = 0.2;  ///< path over the light's distance
  static constexpr double kMinTurn_rad = 0.5;
  /// See MotionSummary; more than an encoder's noise makes.
  static constexpr double kMinSecondCurvature_m = 0.15;
  static constexpr double kMaxPositionStddev_m = 0.03;  ///< sensor x and y
  static constexpr double kMaxPositionStddevPerExtent = 0.1;
  static constexpr double kMaxYawStddev_rad = 0.1;
  static constexpr double kMaxLightStddevPerRange = 0.15;
  static constexpr double kMinLightDistance_m = 0.2;  ///< from the sensor, at the last observation
  static constexpr double kOverLight_m = 0.05;        ///< the sensor is over the light, or nearly
  static constexpr double kMaxOverLight = 0.1;        ///< share of the observations where it is
  static constexpr double kMaxChiSquareSigmas = 6.0;  ///< chi-square < n + this * sqrt(2 n)
  static constexpr double kMinRunnerUpMargin =
      25.0;  ///< cost of the next best answer above the best
};

/// Whether the residuals are as large as their noise, and most observations are in use.
bool fitsWell(const BatchEstimate& batch, const InitializerConfig& config);

/// What the motion alone rules out.
StartObstacle motionObstacle(std::size_t observations, const MotionSummary& motion);

/// What the answer itself lacks.
StartObstacle answerObstacle(const StartAttempt& attempt, const BatchEstimate& batch,
                             const InitializerConfig& config);

}  // namespace bearing_calibration::core
