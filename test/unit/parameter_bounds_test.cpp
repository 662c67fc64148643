// Every number of every shipped parameter file, those of the simulated robot where the file has
// none, is set to what no robot has, one after the other: it is refused, and the sentence names it.

#include <gtest/gtest.h>
#include <ros/time.h>

#include <climits>
#include <functional>
#include <limits>
#include <map>
#include <ostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bearing_calibration_ros/adapter_params.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/drive_params.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {
namespace {

using XmlRpc::XmlRpcValue;

/// What fills the lists that are shipped empty.
const std::map<std::string, std::string> kExamples = {
    {"region/polygon", "[[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]]"},
    {"mask/posts", "[[0.5, 0.1]]"},
    {"colour/lights", "[[1.0, 0.2, 0.3, 0.4]]"},
    {"faults/occlusions", "[[1.0, 2.0]]"},
    {"faults/lost_ticks", "[[1.0, 2.0]]"},
    {"faults/counter_resets", "[[5.0]]"},
    {"faults/left_slips", "[[1.0, 2.0, 0.5]]"},
    {"faults/right_slips", "[[1.0, 2.0, 0.5]]"},
};

/// Names and counts for which every integer, or every one from 0 on, is as good as another.
const std::set<std::string> kWithoutLargest = {"world/seed",        "blink/light_id",
                                               "colour/lights",     "bearings/light_id",
                                               "wheels/left_start", "wheels/right_start"};
const std::set<std::string> kWithoutLeast = {"wheels/left_start", "wheels/right_start"};

struct Node {
  std::string name;
  std::vector<std::string> files;
  std::function<void(const ParameterMap&)> read;
};

void PrintTo(const Node& node, std::ostream* stream) { *stream << node.name; }

template <typename Config>
void readAs(const ParameterMap& parameters) {
  readConfig<Config>(ParamReader(parameters));
}

class ShippedNumbers : public testing::TestWithParam<Node> {
 protected:
  void SetUp() override {
    ros::Time::init();  // of the machine: until then it counts as simulated
    std::vector<std::string> paths;
    for (const std::string& file : GetParam().files) {
      paths.push_back(std::string(BEARING_CALIBRATION_CONFIG_FOLDER) + "/" + file);
    }
    parameters_ = parametersFromFiles(paths);
    const ParameterMap robot = parametersFromFiles(
        {std::string(BEARING_CALIBRATION_CONFIG_FOLDER) + "/robots/simulated.yaml"});
    for (auto& [name, value] : parameters_) {
      const auto given = robot.find(name);
      const bool is_required = value == XmlRpcValue("required");
      ASSERT_TRUE(!is_required || given != robot.end()) << name;
      if (is_required) value = given->second;
    }
    for (const auto& [name, value] : parametersFromFiles({paths.back()})) {
      names_.push_back(name);
      const auto example = kExamples.find(name);
      if (example == kExamples.end()) continue;
      parameters_[name] = parametersFromYaml(example->second, name).at("");
    }
  }

  /// Sets `*number`, a part of `name`'s value in parameters_, to what cannot be.
  void expectRefused(const std::string& name, XmlRpcValue* number) {
    const XmlRpcValue shipped = *number;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::vector<XmlRpcValue> absurd;
    for (const double value : {1e300, -1e300, 1e10, -1e10, std::numeric_limits<double>::quiet_NaN(),
                               kInfinity, -kInfinity}) {
      absurd.emplace_back(value);
    }
    if (kWithoutLargest.count(name) == 0) absurd.emplace_back(INT_MAX);
    if (kWithoutLeast.count(name) == 0) absurd.emplace_back(INT_MIN);
    for (const XmlRpcValue& value : absurd) {
      *number = value;
      expectNamed(name, value);
    }
    *number = shipped;
  }

  void expectNamed(const std::string& name, XmlRpcValue value) {
    std::ostringstream text;
    text << name << ": " << value;
    try {
      GetParam().read(parameters_);
      ADD_FAILURE() << text.str() << " is taken";
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos)
          << text.str() << " is not named in:\n"
          << error.what();
    }
  }

  /// Every number in a value, those of lists in lists, too.
  void expectEachRefused(const std::string& name, XmlRpcValue* value) {
    switch (value->getType()) {
      case XmlRpcValue::TypeInt:
      case XmlRpcValue::TypeDouble:
        expectRefused(name, value);
        ++numbers_;
        break;
      case XmlRpcValue::TypeArray:
        EXPECT_GT(value->size(), 0) << name << " wants an example above";
        for (int i = 0; i < value->size(); ++i) expectEachRefused(name, &(*value)[i]);
        break;
      default:
        break;  // a name, or true or false
    }
  }

  ParameterMap parameters_;
  std::vector<std::string> names_;
  int numbers_ = 0;
};

TEST_P(ShippedNumbers, AreRefusedByNameBeyondWhatARobotHas) {
  ASSERT_NO_THROW(GetParam().read(parameters_));
  for (const std::string& name : names_) expectEachRefused(name, &parameters_.at(name));
  constexpr int kLeast = 6;  // in adapter.yaml, the shortest of them
  EXPECT_GE(numbers_, kLeast);
}

INSTANTIATE_TEST_SUITE_P(
    Nodes, ShippedNumbers,
    testing::Values(Node{"adapter", {"adapter.yaml"}, readAs<AdapterNodeConfig>},
                    Node{"calibration", {"calibration.yaml"}, readAs<CalibrationNodeConfig>},
                    Node{"detection", {"detection.yaml"}, readAs<DetectionNodeConfig>},
                    Node{"drive", {"calibration.yaml", "drive.yaml"}, readAs<DriveNodeConfig>},
                    Node{"simulation", {"simulation.yaml"}, readAs<SimulationNodeConfig>}),
    [](const auto& node) { return node.param.name; });

}  // namespace
}  // namespace bearing_calibration_ros
