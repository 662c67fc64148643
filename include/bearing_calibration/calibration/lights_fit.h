#pragma once

#include <vector>

#include "bearing_calibration/calibration/batch_estimator.h"
#include "bearing_calibration/calibration/lights_smoother.h"
#include "bearing_calibration/calibration/own_answer.h"

namespace bearing_calibration {

/// Where a fit of several lights begins, and what it believes.
struct LightsStart {
  LightsLayout layout;
  LightsPath path;
  LightsWeights weights;
};

/// From what each light's own calibration has decided of its sights: outliers are left out, motions
/// that any of them gave up are given up, and the path is that of the surest one.
/// @param images  in the order of time; its light i is the one of answers[i]
LightsStart startFromAnswers(const std::vector<LightsImage>& images,
                             const std::vector<const OwnAnswer*>& answers,
                             const ErrorPriors& errors);

/// What a record of several lights says about the mount they share.
struct LightsFit {
  bool settled = false;
  LightsEstimate last;  ///< at the last image
  int iterations = 0;
  double chi_square = 0.0;  ///< of the bearings in use, each given those before it
  int degrees_of_freedom = 0;
};

/// The most probable mount, lights and path given all bearings: Gauss-Newton by smoother passes.
LightsFit fitLights(const std::vector<LightsImage>& images, const LightsStart& start,
                    const BatchConfig& config);

/// The answer whose mount is known best.
const OwnAnswer& surestOf(const std::vector<const OwnAnswer*>& answers);

}  // namespace bearing_calibration
