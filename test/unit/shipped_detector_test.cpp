// What the core's tests and the tables call the shipped detector is what config/detection.yaml
// says.

#include <gtest/gtest.h>

#include <vector>

#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration_ros {
namespace {

std::vector<double> numbersOf(const core::DetectorConfig& c) {
  return {static_cast<double>(c.sensor.width_px),
          static_cast<double>(c.sensor.height_px),
          c.sensor.black_level,
          c.sensor.saturation_level,
          c.sensor.read_noise_electrons,
          c.sensor.response_spread,
          c.mirror.focal_length_m,
          c.mirror.aperture_m,
          c.mirror.focus_distance_m,
          c.mirror.pixel_pitch_m,
          c.mirror.lens_to_apex_m,
          c.mirror.half_angle_rad,
          c.mirror.base_radius_m,
          c.optics_stddev.scale,
          c.optics_stddev.aperture,
          c.optics_stddev.focus,
          c.optics_stddev.half_angle_rad,
          c.view.centre_u_px,
          c.view.centre_v_px,
          static_cast<double>(c.view.handedness),
          c.mask.inner_radius_px,
          c.mask.outer_radius_px,
          static_cast<double>(c.mask.first_row),
          static_cast<double>(c.mask.last_row),
          static_cast<double>(c.mask.posts.size()),
          c.threshold.min_contrast_levels,
          c.threshold.spreads,
          c.light.min_distance_m,
          c.light.max_distance_m,
          c.light.min_radius_m,
          c.light.radius_m,
          c.light.half_height_m,
          c.light.brightness_spread,
          c.light.max_height_m,
          c.gates.mirror ? 1.0 : 0.0,
          static_cast<double>(c.gates.min_pixels),
          static_cast<double>(c.gates.max_pixels),
          c.gates.min_probability,
          c.alignment.centre_stddev_px,
          c.alignment.elevation_stddev_rad,
          c.alignment.geometry.harmonic_stddev_rad,
          c.alignment.geometry.near_per_far_m,
          c.alignment.geometry.nearness_stddev_rad_m,
          c.defocus_sigma_px,
          static_cast<double>(c.max_candidates)};
}

TEST(ShippedDetector, IsThatOfTheConfigurationFile) {
  const ParamReader file(parametersFromFiles({packagedConfig("detection.yaml")}), "detection.yaml");
  const core::DetectorConfig shipped = readConfig<DetectionNodeConfig>(file).detector;
  const core::DetectorConfig tested = core::test::shippedDetector();
  const std::vector<double> expected = numbersOf(shipped);
  const std::vector<double> actual = numbersOf(tested);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(actual[i], expected[i], 1e-12) << "number " << i;
  }
  constexpr double kRounded = 1e-4;  // the file has four digits
  EXPECT_NEAR(tested.sensor.electrons_per_level / shipped.sensor.electrons_per_level, 1.0,
              kRounded);
}

}  // namespace
}  // namespace bearing_calibration_ros
