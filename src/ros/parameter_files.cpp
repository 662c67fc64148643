#include "bearing_calibration_ros/parameter_files.h"

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <limits>
#include <regex>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration_ros {
namespace {

using XmlRpc::XmlRpcValue;

XmlRpcValue numberFrom(const std::string& digits) { return XmlRpcValue(std::stod(digits)); }

/// A plain word as the YAML 1.1 reader of rosparam takes it: 1e-6, without a point, is a string.
XmlRpcValue scalarFrom(const std::string& text) {
  static const std::regex kInteger("[-+]?[0-9]+");
  static const std::regex kNumber("[-+]?([0-9]+\\.[0-9]*|\\.[0-9]+)([eE][-+][0-9]+)?");
  static const std::regex kTrue("true|True|TRUE|yes|Yes|YES|on|On|ON");
  static const std::regex kFalse("false|False|FALSE|no|No|NO|off|Off|OFF");
  static const std::regex kInfinite("([-+]?)\\.(inf|Inf|INF)");
  static const std::regex kNotANumber("\\.(nan|NaN|NAN)");
  static const std::regex kAngle("(deg|rad)\\(\\s*([-+]?[0-9.]+([eE][-+]?[0-9]+)?)\\s*\\)");
  std::smatch match;
  if (std::regex_match(text, kInteger)) return XmlRpcValue(std::stoi(text));
  if (std::regex_match(text, kNumber)) return numberFrom(text);
  if (std::regex_match(text, kTrue)) return XmlRpcValue(true);
  if (std::regex_match(text, kFalse)) return XmlRpcValue(false);
  if (std::regex_match(text, kNotANumber)) {
    return XmlRpcValue(std::numeric_limits<double>::quiet_NaN());
  }
  if (std::regex_match(text, match, kInfinite)) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    return XmlRpcValue(match[1] == "-" ? -kInf : kInf);
  }
  if (std::regex_match(text, match, kAngle)) {
    const double value = std::stod(match[2]);
    return XmlRpcValue(match[1] == "deg" ? bearing_calibration::radiansFromDegrees(value) : value);
  }
  return XmlRpcValue(text);
}

XmlRpcValue valueFrom(const YAML::Node& node) {
  constexpr char kQuoted[] = "!";  // yaml-cpp's tag of a scalar in quotes
  if (node.IsScalar()) {
    return node.Tag() == kQuoted ? XmlRpcValue(node.Scalar()) : scalarFrom(node.Scalar());
  }
  XmlRpcValue value;
  if (node.IsSequence()) {
    value.setSize(static_cast<int>(node.size()));
    for (int i = 0; i < value.size(); ++i) value[i] = valueFrom(node[i]);
  } else if (node.IsMap()) {
    for (const auto& entry : node) value[entry.first.Scalar()] = valueFrom(entry.second);
  } else {
    value = XmlRpcValue(std::string());  // rosparam knows no null; a reader will name the parameter
  }
  return value;
}

/// Single values of `over` replace those of `tree`; groups are joined.
void overlay(XmlRpcValue* tree, XmlRpcValue& over) {
  const bool both_groups =
      tree->getType() == XmlRpcValue::TypeStruct && over.getType() == XmlRpcValue::TypeStruct;
  if (!both_groups) {
    *tree = over;
    return;
  }
  for (auto& [name, value] : over) overlay(&(*tree)[name], value);
}

}  // namespace

XmlRpcValue parametersFromFiles(const std::vector<std::string>& files) {
  XmlRpcValue tree;
  for (const std::string& file : files) {
    try {
      const YAML::Node root = YAML::LoadFile(file);
      if (!root.IsMap()) throw std::runtime_error("it is not a list of names and values");
      XmlRpcValue values = valueFrom(root);
      overlay(&tree, values);
    } catch (const YAML::BadFile&) {
      throw std::runtime_error(file + ": cannot be opened");
    } catch (const std::exception& error) {
      throw std::runtime_error(file + ": " + error.what());
    }
  }
  return tree;
}

}  // namespace bearing_calibration_ros
