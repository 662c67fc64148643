// Every number of every shipped parameter file, those of the simulated robot where the file has
// none, is set to what no robot has, one after the other: it is refused, and the sentence names it.
// The bounds that are declared, which the reference page and the thresholds' clients show, are
// where values begin to be refused.

#include "bearing_calibration/common/parameter_bounds.h"

#include <gtest/gtest.h>
#include <ros/time.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <ostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bearing_calibration/common/formatted.h"
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
  core::Bounds bounds;
};

void PrintTo(const Node& node, std::ostream* stream) { *stream << node.name; }

template <typename Config>
Node nodeWith(const std::string& name, const std::vector<std::string>& files) {
  return {name, files,
          [](const ParameterMap& parameters) { readConfig<Config>(ParamReader(parameters)); },
          core::Bounds(Config())};
}

/// As an integer where it is one, which a parameter of either kind takes.
XmlRpcValue numberOf(double value) {
  const bool is_integer = value == std::floor(value) && std::abs(value) <= INT_MAX;
  return is_integer ? XmlRpcValue(static_cast<int>(value)) : XmlRpcValue(value);
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

  /// What is said when a parameter has this value, all others as they are shipped.
  std::string errorsWith(const std::string& name, const XmlRpcValue& value) {
    const XmlRpcValue shipped = std::exchange(parameters_.at(name), value);
    std::string errors;
    try {
      GetParam().read(parameters_);
    } catch (const std::runtime_error& error) {
      errors = error.what();
    }
    parameters_.at(name) = shipped;
    return errors;
  }

  /// @param side  -1 for the least, 1 for the most that is allowed
  void expectToBeginAt(const std::string& name, double bound, int side) {
    constexpr double kBeyond = 1e-6;         // of the bound
    constexpr double kSmallestBound = 1e-9;  // of those that are not 0
    const bool is_integer = parameters_.at(name).getType() == XmlRpcValue::TypeInt;
    const double step = is_integer ? 1.0 : kBeyond * std::max(std::abs(bound), kSmallestBound);
    const std::string refused = name + " must lie in";
    EXPECT_EQ(errorsWith(name, numberOf(bound)).find(refused), std::string::npos) << bound;
    if (bound == INT_MAX) return;
    EXPECT_NE(errorsWith(name, numberOf(bound + side * step)).find(refused), std::string::npos)
        << name << " beyond " << bound;
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

TEST_P(ShippedNumbers, AreBoundedAsDeclaredWhateverTheOthersAre) {
  int found = 0;
  for (const auto& [name, range] : GetParam().bounds.ranges()) {
    if (std::count(names_.begin(), names_.end(), name) == 0) continue;  // of another file
    ++found;
    expectToBeginAt(name, range.least, -1);
    expectToBeginAt(name, range.most, 1);
  }
  constexpr int kLeast = 6;
  EXPECT_GE(found, kLeast);
}

TEST_P(ShippedNumbers, ChoicesAreThoseThatAreDeclared) {
  for (const auto& [name, names] : GetParam().bounds.choices()) {
    if (std::count(names_.begin(), names_.end(), name) == 0) continue;
    const std::string refused = name + " must be one of (" + core::joined(names, ", ") + ")";
    EXPECT_NE(errorsWith(name, XmlRpcValue("none of them")).find(refused), std::string::npos);
    for (const std::string& each : names) {
      EXPECT_EQ(errorsWith(name, XmlRpcValue(each)).find(refused), std::string::npos) << each;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Nodes, ShippedNumbers,
    testing::Values(nodeWith<AdapterNodeConfig>("adapter", {"adapter.yaml"}),
                    nodeWith<CalibrationNodeConfig>("calibration", {"calibration.yaml"}),
                    nodeWith<DetectionNodeConfig>("detection", {"detection.yaml"}),
                    nodeWith<DriveNodeConfig>("drive", {"calibration.yaml", "drive.yaml"}),
                    nodeWith<SimulationNodeConfig>("simulation", {"simulation.yaml"})),
    [](const auto& node) { return node.param.name; });

}  // namespace
}  // namespace bearing_calibration_ros
