#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bearing_calibration/calibration/lights_record.h"
#include "bearing_calibration/filter/lights_state.h"

namespace bearing_calibration {

/// How one image is weighed in a smoother pass.
struct LightsImageWeight {
  std::array<bool, kMostLights> use{};  ///< of each light's bearing, where it is seen
  bool slipped = false;                 ///< the motion to this image is not trusted at all
};

/// What a pass is linearised about: a path that its motions and their errors really make.
struct LightsPath {
  std::vector<LightsVector> states;            ///< at each image
  std::vector<Eigen::Vector3d> motion_errors;  ///< of the motion to each image (x, y, yaw)
};

/// The path that ends in a state, with given errors of all motions.
LightsPath pathTo(const LightsLayout& layout, const LightsVector& last,
                  const std::vector<LightsImage>& images,
                  const std::vector<Eigen::Vector3d>& motion_errors);

/// A whole record of several lights, smoothed once.
struct LightsPass {
  LightsEstimate last;  ///< filtered, which is smoothed too, at the last image
  std::vector<Eigen::Vector3d> motion_errors;
  double chi_square = 0.0;  ///< of the bearings in use, each against those before it
  int bearings = 0;         ///< in use
};

/// What a whole record is weighed by.
struct LightsWeights {
  std::vector<LightsImageWeight> images;
  std::array<double, kMostLights> widening{};  ///< of each light's variances
};

/// The smoother of the batch (doc/start.md, eq. 6) for several lights: Kalman filter forward,
/// disturbances backward, linearised about `path`. Which bearings and motions are believed has been
/// decided before.
/// @param errors  what is known of the robot's errors beforehand
LightsPass smoothLights(const std::vector<LightsImage>& images, const LightsWeights& weights,
                        const LightsLayout& layout, const LightsPath& path,
                        const ErrorPriors& errors);

}  // namespace bearing_calibration
