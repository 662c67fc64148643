#include "tools/study/wrong_rigs.h"

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

std::vector<WrongRig> wrongRigs(const RendererConfig& right) {
  std::vector<WrongRig> rigs{{"as configured", right, right.reference_height_m}};
  const auto add = [&](const std::string& name, double amount, auto change) {
    for (double sign : {-1.0, 1.0}) {
      WrongRig rig{name + (sign < 0.0 ? " less" : " more"), right, right.reference_height_m};
      change(&rig, sign * amount);
      rigs.push_back(rig);
    }
  };
  add("focal length 5 %", 0.05,
      [](WrongRig* rig, double part) { rig->rendered.rig.focal_length_m *= 1.0 + part; });
  add("pixel pitch 5 %", 0.05,
      [](WrongRig* rig, double part) { rig->rendered.rig.pixel_m *= 1.0 + part; });
  add("half angle 2 deg", radiansFromDegrees(2.0),
      [](WrongRig* rig, double off) { rig->rendered.rig.cone_half_angle_rad += off; });
  add("focus 20 %", 0.2,
      [](WrongRig* rig, double part) { rig->rendered.rig.focus_distance_m *= 1.0 + part; });
  add("aperture 35 %", 0.35,
      [](WrongRig* rig, double part) { rig->rendered.rig.aperture_m *= 1.0 + part; });
  add("centre 3 px", 3.0,
      [](WrongRig* rig, double off) { rig->rendered.rig.centre_px.x() += off; });
  add("tilt 1 deg", radiansFromDegrees(1.0),
      [](WrongRig* rig, double off) { rig->rendered.rig.axis_lean.x() += off; });
  add("light 100 mm from the apex", 0.1,
      [](WrongRig* rig, double off) { rig->light_height_m = off; });
  return rigs;
}

}  // namespace bearing_calibration::core
