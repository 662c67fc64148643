#pragma once

#include <array>
#include <cstddef>

#include "bearing_calibration/vision/light_detector.h"
#include "tools/study/random_scene.h"

namespace bearing_calibration::core {

/// How often a track of probability 0.5 or more is there, and is the light, at moments of drives
/// through random scenes.
class SceneDrives {
 public:
  static constexpr double kRate_hz = 5.0;
  static constexpr std::array<int, 4> kMoments = {1, 5, 10, 15};  ///< [images]: 3 s in all

  /// Drives an arc from where the scene's image was taken, with the first `lights` of its lights.
  void drive(const RandomScene& scene, std::size_t lights, LightDetector* detector);
  void print() const;

 private:
  struct Counts {
    int drives = 0;
    std::array<int, kMoments.size()> right{};
    std::array<int, kMoments.size()> wrong{};
  };
  std::array<Counts, 2> counts_;  ///< without light, with
};

}  // namespace bearing_calibration::core
