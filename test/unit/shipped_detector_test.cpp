// What the core's tests and the tables call the shipped detector is what config/detection.yaml
// says of the simulated robot's camera.

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <variant>

#include "bearing_calibration/common/parameters.h"
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

std::map<std::string, double> numbersOf(core::DetectorConfig config) {
  Numbers numbers;
  config.declare(numbers);
  numbers.all["mask/posts"] = static_cast<double>(config.mask.posts.size());
  return numbers.all;
}

TEST(ShippedDetector, IsThatOfTheConfigurationFile) {
  const ParamReader file(parametersFromFiles(
      {packagedConfig("detection.yaml"), packagedConfig("robots/simulated.yaml")}));
  const auto shipped = numbersOf(readConfig<DetectionNodeConfig>(file).detector);
  const auto tested = numbersOf(core::test::shippedDetector());
  ASSERT_GT(shipped.size(), 40U);
  for (const auto& [name, value] : shipped) {
    const bool is_rounded = name == "sensor/electrons_per_level";  // to four digits in the file
    EXPECT_NEAR(tested.at(name), value, is_rounded ? 1e-4 * value : 1e-12) << name;
  }
}

}  // namespace
}  // namespace bearing_calibration_ros
