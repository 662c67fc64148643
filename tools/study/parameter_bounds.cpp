// The bounds of the nodes' parameters, a line "FILE NAME BOUNDS" for each:
// scripts/reference_pages.py

#include "bearing_calibration/common/parameter_bounds.h"

#include <cstdio>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/adapter_params.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/drive_params.h"
#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {
namespace {

template <typename Config>
void print(const char* file) {
  const core::Bounds bounds{Config()};
  for (const auto& [name, range] : bounds.ranges()) {
    std::printf("%s %s %.10g to %.10g\n", file, name.c_str(), range.least, range.most);
  }
  for (const auto& [name, names] : bounds.choices()) {
    std::printf("%s %s %s\n", file, name.c_str(), core::joined(names, ", ").c_str());
  }
}

}  // namespace
}  // namespace bearing_calibration_ros

int main() {
  namespace ros_side = bearing_calibration_ros;
  ros_side::print<ros_side::CalibrationNodeConfig>("calibration.yaml");
  ros_side::print<ros_side::DetectionNodeConfig>("detection.yaml");
  ros_side::print<ros_side::AdapterNodeConfig>("adapter.yaml");
  ros_side::print<ros_side::DriveNodeConfig>("drive.yaml");
  ros_side::print<ros_side::SimulationNodeConfig>("simulation.yaml");
}
