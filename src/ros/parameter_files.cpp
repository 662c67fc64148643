#include "bearing_calibration_ros/parameter_files.h"

#include <ros/package.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {
namespace {

using core::formatted;
using XmlRpc::XmlRpcValue;

std::runtime_error errorAt(const std::string& origin, const YAML::Mark& mark,
                           const std::string& what) {
  return std::runtime_error(origin + ": line " + std::to_string(mark.line + 1) + ": " + what);
}

/// Digits may be grouped by underscores in YAML 1.1.
std::string withoutUnderscores(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), '_'), text.end());
  return text;
}

XmlRpcValue integerFrom(const std::string& text) {
  constexpr int kAnyBase = 0;  // as written: 0x.. is hexadecimal, 0.. octal
  errno = 0;
  const long long value = std::strtoll(withoutUnderscores(text).c_str(), nullptr, kAnyBase);
  if (errno != 0 || value < std::numeric_limits<int>::min() ||
      value > std::numeric_limits<int>::max()) {
    throw std::runtime_error("the integer " + text + " does not fit into 32 bits");
  }
  return XmlRpcValue(static_cast<int>(value));
}

/// Infinite where the text says more than a double holds, as in Python: a reader names the
/// parameter.
double realFrom(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

/// What PyYAML, and with it roslaunch and rosparam, takes a plain scalar for.
XmlRpcValue scalarFrom(const std::string& text) {
  static const std::regex kTrue("yes|Yes|YES|true|True|TRUE|on|On|ON");
  static const std::regex kFalse("no|No|NO|false|False|FALSE|off|Off|OFF");
  static const std::regex kInteger("[-+]?(0|[1-9][0-9_]*|0[0-7_]+|0x[0-9a-fA-F_]+)");
  static const std::regex kReal(
      "[-+]?([0-9][0-9_]*)\\.[0-9_]*([eE][-+][0-9]+)?|\\.[0-9][0-9_]*([eE][-+][0-9]+)?");
  static const std::regex kInfinity("([-+]?)\\.(inf|Inf|INF)");
  static const std::regex kNotANumber("\\.(nan|NaN|NAN)");
  static const std::regex kAngle(
      "(deg|rad)\\(\\s*([-+]?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][-+]?[0-9]+)?)\\s*\\)");
  constexpr std::size_t kLongestNumber = 100;  // std::regex wants its stack for each character
  if (text.size() > kLongestNumber) return XmlRpcValue(text);
  std::smatch match;
  if (std::regex_match(text, kTrue)) return XmlRpcValue(true);
  if (std::regex_match(text, kFalse)) return XmlRpcValue(false);
  if (std::regex_match(text, kInteger)) return integerFrom(text);
  if (std::regex_match(text, kReal)) return XmlRpcValue(realFrom(withoutUnderscores(text)));
  if (std::regex_match(text, match, kInfinity)) {
    const double infinity = std::numeric_limits<double>::infinity();
    return XmlRpcValue(match[1] == "-" ? -infinity : infinity);
  }
  if (std::regex_match(text, kNotANumber)) {
    return XmlRpcValue(std::numeric_limits<double>::quiet_NaN());
  }
  if (std::regex_match(text, match, kAngle)) {
    const double angle = realFrom(match[2]);
    return XmlRpcValue(match[1] == "deg" ? core::radiansFromDegrees(angle) : angle);
  }
  return XmlRpcValue(text);
}

/// Turns a document into parameters, and ends where it is none: aliases may stand for any number of
/// values, and for themselves.
class TreeReader {
 public:
  explicit TreeReader(const std::string& origin) : origin_(origin) {}

  XmlRpcValue read(const YAML::Node& node, int depth = 0) {
    constexpr int kMostValues = 10000;  // fifty times as many as the largest of config/
    constexpr int kDeepest = 20;
    if (++values_ > kMostValues || depth > kDeepest) {
      throw errorAt(
          origin_, node.Mark(),
          formatted("more than %d values or %d levels, aliases counted each time: this is "
                    "no parameter file",
                    kMostValues, kDeepest));
    }
    if (node.IsScalar()) return scalar(node);
    XmlRpcValue value;
    if (node.IsSequence()) {
      value.setSize(static_cast<int>(node.size()));
      for (std::size_t i = 0; i < node.size(); ++i) {
        value[static_cast<int>(i)] = read(node[i], depth + 1);
      }
      return value;
    }
    if (!node.IsMap()) return XmlRpcValue(std::string());  // null: a reader will name the parameter
    for (const auto& member : node) value[member.first.Scalar()] = read(member.second, depth + 1);
    return value;
  }

 private:
  XmlRpcValue scalar(const YAML::Node& node) const {
    const bool is_quoted = node.Tag() == "!";
    if (is_quoted) return XmlRpcValue(node.Scalar());
    try {
      return scalarFrom(node.Scalar());
    } catch (const std::runtime_error& error) {
      throw errorAt(origin_, node.Mark(), error.what());
    }
  }

  std::string origin_;
  int values_ = 0;
};

std::string readText(const std::string& path) {
  constexpr std::size_t kMostBytes = 1U << 20U;  // a hundred times the largest of config/
  std::ifstream file(path);
  std::string text(kMostBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.empty()) throw std::runtime_error(path + ": cannot be read, or is empty");
  if (text.size() > kMostBytes) {
    throw std::runtime_error(path + ": more than 1 MB: this is no parameter file");
  }
  return text;
}

XmlRpcValue parametersFromFile(const std::string& path) {
  XmlRpcValue tree = parametersFromYaml(readText(path), path);
  if (tree.getType() != XmlRpcValue::TypeStruct) {
    throw std::runtime_error(path + ": it is not a list of names and values");
  }
  return tree;
}

/// Single values of `over` replace those of `tree`; groups are joined.
void join(XmlRpcValue* tree, XmlRpcValue& over) {
  const bool both_groups =
      tree->getType() == XmlRpcValue::TypeStruct && over.getType() == XmlRpcValue::TypeStruct;
  if (!both_groups) {
    *tree = over;
    return;
  }
  for (auto& [name, value] : over) join(&(*tree)[name], value);
}

}  // namespace

XmlRpcValue parametersFromYaml(const std::string& text, const std::string& origin) {
  try {
    return TreeReader(origin).read(YAML::Load(text));
  } catch (const YAML::Exception& error) {
    throw errorAt(origin, error.mark, error.msg);
  }
}

std::string packagedConfig(const std::string& file) {
  const std::string package = ros::package::getPath("bearing_calibration");
  if (package.empty()) {
    throw std::runtime_error("the package is not on ROS_PACKAGE_PATH: use rosrun");
  }
  return package + "/config/" + file;
}

XmlRpcValue parametersFromFiles(const std::vector<std::string>& files) {
  XmlRpcValue tree;
  for (const std::string& file : files) {
    XmlRpcValue values = parametersFromFile(file);
    join(&tree, values);
  }
  return tree;
}

void ParameterFiles::addNode(const std::string& node, const std::string& path) {
  trees_[node] = parametersFromFile(path);
}

void ParameterFiles::overlay(const std::string& path) {
  XmlRpcValue tree = parametersFromFile(path);
  for (const std::string& name : namesIn(tree)) place(name, *findIn(&tree, name), path);
}

void ParameterFiles::set(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == assignment.size()) {
    throw std::runtime_error("'" + assignment +
                             "' is not of the form NAME=VALUE, such as wheels/separation=0.40");
  }
  const std::string name = assignment.substr(0, equals);
  place(name, parametersFromYaml(assignment.substr(equals + 1), name), "the command line");
}

void ParameterFiles::place(const std::string& name, const XmlRpcValue& value,
                           const std::string& origin) {
  bool known = false;
  for (auto& node_and_tree : trees_) {
    XmlRpcValue* found = findIn(&node_and_tree.second, name);
    if (found == nullptr || found->getType() == XmlRpcValue::TypeStruct) continue;
    *found = value;
    known = true;
  }
  if (!known) errors_.push_back("parameter " + name + " is not known (misspelt?): " + origin);
}

ParamReader ParameterFiles::reader(const std::string& node) const {
  ParamReader reader(trees_.at(node), "");
  for (const std::string& error : errors_) reader.addError(error);
  return reader;
}

}  // namespace bearing_calibration_ros
