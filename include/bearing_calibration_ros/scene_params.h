#pragma once

#include <cstdint>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// Groups `camera` (but for its rate), `mirror` and `exposure`, and the mirror's own look in
/// `surroundings`. Values are not validated.
core::RendererConfig readRenderer(ParamReader& params, std::uint64_t seed);

/// Groups `ring`, `clutter` and the room in `surroundings`, and world/lights. Not validated.
core::SceneConfig readScene(ParamReader& params, std::uint64_t seed);

}  // namespace bearing_calibration_ros
