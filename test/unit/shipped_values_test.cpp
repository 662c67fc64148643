// What the core says for programs without files, and what its tests and the tables call the shipped
// detector, is what the parameter files say, with the simulated robot's numbers.

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <variant>

#include "bearing_calibration/calibration/shipped_calibration.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration_ros {
namespace {

/// The numbers that a configuration declares, by name.
class Numbers : public core::Parameters {
 public:
  std::map<std::string, double> all;

 private:
  bool readInto(const std::string& name, const Target& target) override {
    if (const auto* number = std::get_if<double*>(&target)) all[name] = **number;
    if (const auto* integer = std::get_if<int*>(&target)) all[name] = **integer;
    if (const auto* flag = std::get_if<bool*>(&target)) all[name] = **flag ? 1.0 : 0.0;
    return false;
  }
};

template <typename Config>
std::map<std::string, double> numbersOf(Config config) {
  Numbers numbers;
  config.declare(numbers);
  return numbers.all;
}

ParamReader simulatedRobotWith(const std::string& file) {
  return ParamReader(
      parametersFromFiles({packagedConfig(file), packagedConfig("robots/simulated.yaml")}));
}

TEST(ShippedCalibration, IsThatOfTheConfigurationFile) {
  const core::CalibratorConfig shipped =
      readConfig<CalibrationNodeConfig>(simulatedRobotWith("calibration.yaml")).calibrator;
  const core::CalibratorConfig said = core::shippedCalibration(shipped.drive);
  const auto numbers = numbersOf(shipped);
  ASSERT_GT(numbers.size(), 20U);
  EXPECT_EQ(numbersOf(said), numbers);
  // the parts that parameters are no members of
  EXPECT_EQ(said.initializer.batch.errors.stddev, shipped.initializer.batch.errors.stddev);
  EXPECT_EQ(said.initializer.batch.errors.mean, shipped.initializer.batch.errors.mean);
  EXPECT_EQ(said.filter.parametrisation, shipped.filter.parametrisation);
  EXPECT_EQ(said.bearings.latency_s, shipped.bearings.latency_s);
}

TEST(ShippedDetector, IsThatOfTheConfigurationFile) {
  const core::DetectorConfig file =
      readConfig<DetectionNodeConfig>(simulatedRobotWith("detection.yaml")).detector;
  const core::DetectorConfig detector = core::test::shippedDetector();
  EXPECT_EQ(file.mirror_kind, detector.mirror_kind);
  EXPECT_EQ(file.mask.posts.size(), detector.mask.posts.size());
  const auto shipped = numbersOf(file);
  const auto tested = numbersOf(detector);
  ASSERT_GT(shipped.size(), 40U);
  for (const auto& [name, value] : shipped) {
    const bool is_rounded = name == "sensor/electrons_per_level";  // to four digits in the file
    EXPECT_NEAR(tested.at(name), value, is_rounded ? 1e-4 * value : 1e-12) << name;
  }
}

// One file has all numbers of a robot, its frames, too.
TEST(RobotFile, MayNameBothFramesForTheDetectionAsWell) {
  ParameterMap robot = parametersFromFiles(
      {packagedConfig("detection.yaml"), packagedConfig("robots/simulated.yaml")});
  robot["frames/base"] = XmlRpc::XmlRpcValue("base_footprint");
  robot["frames/sensor"] = XmlRpc::XmlRpcValue("eye");
  EXPECT_EQ(readConfig<DetectionNodeConfig>(ParamReader(robot)).sensor_frame, "eye");
  robot["frames/bsae"] = XmlRpc::XmlRpcValue("base_footprint");
  EXPECT_THROW(readConfig<DetectionNodeConfig>(ParamReader(robot)), std::runtime_error);
}

}  // namespace
}  // namespace bearing_calibration_ros
