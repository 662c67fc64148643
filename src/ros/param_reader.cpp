#include "bearing_calibration_ros/param_reader.h"

#include <ros/param.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <variant>

#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration_ros {
namespace {

using core::Parameters;
using XmlRpc::XmlRpcValue;

std::string groupOf(const std::string& name) {
  const std::size_t slash = name.find('/');
  return slash == std::string::npos ? std::string() : name.substr(0, slash + 1);
}

/// False, and the target as it was, for a value of another kind.
template <typename Value>
bool take(XmlRpcValue::Type type, XmlRpcValue& value, Value& target) {
  if (value.getType() != type) return false;
  target = static_cast<Value&>(value);
  return true;
}
bool take(XmlRpcValue& value, int& target) { return take(XmlRpcValue::TypeInt, value, target); }
bool take(XmlRpcValue& value, bool& target) {
  return take(XmlRpcValue::TypeBoolean, value, target);
}
bool take(XmlRpcValue& value, std::string& target) {
  return take(XmlRpcValue::TypeString, value, target);
}
bool take(XmlRpcValue& value, double& target) {
  int whole = 0;
  double number = 0.0;
  if (take(value, whole)) {
    number = whole;
  } else if (!take(XmlRpcValue::TypeDouble, value, number) || !std::isfinite(number)) {
    return false;
  }
  target = number;
  return true;
}
bool take(XmlRpcValue& value, std::vector<double>& targets) {
  if (value.getType() != XmlRpcValue::TypeArray) return false;
  std::vector<double> numbers(static_cast<std::size_t>(value.size()));
  for (int i = 0; i < value.size(); ++i) {
    if (!take(value[i], numbers[static_cast<std::size_t>(i)])) return false;
  }
  if (numbers.size() != targets.size()) return false;
  targets = numbers;
  return true;
}

bool take(XmlRpcValue& value, Parameters::Rows& target) {
  if (value.getType() != XmlRpcValue::TypeArray) return false;
  std::vector<std::vector<double>> rows(static_cast<std::size_t>(value.size()),
                                        std::vector<double>(target.size));
  for (int i = 0; i < value.size(); ++i) {
    if (!take(value[i], rows[static_cast<std::size_t>(i)])) return false;
  }
  target.rows = rows;
  return true;
}

std::string kindOf(double) { return "a finite number"; }
std::string kindOf(int) { return "an integer"; }
std::string kindOf(bool) { return "true or false"; }
std::string kindOf(const std::string&) { return "a string"; }
std::string kindOf(const std::vector<double>& numbers) {
  return "a list of " + std::to_string(numbers.size()) + " finite numbers";
}
std::string kindOf(const Parameters::Rows& target) {
  return "a list of lists of " + std::to_string(target.size) + " finite numbers";
}

/// In place of a number that only the robot's owner knows.
bool isRequired(XmlRpcValue& value, const Parameters::Target& target) {
  std::string text;
  const bool is_number =
      std::holds_alternative<double*>(target) || std::holds_alternative<int*>(target);
  return is_number && take(value, text) && text == "required";
}

/// Whose it is, with the page that says how to find it out.
std::string ownerOf(const std::string& name) {
  return groupOf(name) == "wheels/" ? "robot (robots.md)" : "camera and mirror (camera.md)";
}

std::string listed(const std::vector<std::string>& sentences) {
  std::string text = std::to_string(sentences.size()) + " wrong parameter(s):";
  for (const std::string& sentence : sentences) text += "\n  - " + sentence;
  return text;
}

void flatten(XmlRpcValue& value, const std::string& name, ParameterMap* parameters) {
  if (value.getType() != XmlRpcValue::TypeStruct) {
    (*parameters)[name] = value;
    return;
  }
  for (auto& [key, child] : value) {
    flatten(child, name.empty() ? key : name + "/" + key, parameters);
  }
}

/// All parameters below the node's name, in one request to the master.
ParameterMap parametersOf(const ros::NodeHandle& node_handle) {
  XmlRpcValue tree;
  ParameterMap parameters;
  if (ros::param::get(node_handle.getNamespace(), tree)) flatten(tree, "", &parameters);
  return parameters;
}

/// A value as it would stand in a YAML file.
std::string yamlOf(XmlRpcValue& value) {
  YAML::Emitter text;
  std::string list;
  switch (value.getType()) {
    case XmlRpcValue::TypeString:
      text << YAML::DoubleQuoted << static_cast<std::string>(value);
      return text.c_str();
    case XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpcValue::TypeInt:
      return core::shortestText(static_cast<int>(value));
    case XmlRpcValue::TypeDouble:
      return core::shortestText(static_cast<double>(value));
    case XmlRpcValue::TypeArray:
      for (int i = 0; i < value.size(); ++i) list += (i == 0 ? "" : ", ") + yamlOf(value[i]);
      return '[' + list + ']';
    default:
      return {};
  }
}

/// What is wrong with a value, as its writer would recognise it.
template <typename Target>
std::string describe(XmlRpcValue& value, const Target&) {
  std::string text;
  if (value.getType() == XmlRpcValue::TypeArray)
    return "is a list of " + std::to_string(value.size());
  if (!take(value, text)) return "is " + yamlOf(value);
  char* end = nullptr;
  const bool is_number = std::isfinite(std::strtod(text.c_str(), &end)) && *end == '\0';
  const bool looks_like_number = is_number && !text.empty();
  return "is the string '" + text + "'" +
         (looks_like_number ? " (YAML needs a point and no quotes: 1.0e-6)" : "");
}

std::string describe(XmlRpcValue& value, const Parameters::Rows& target) {
  std::vector<double> row(target.size);
  for (int i = 0; value.getType() == XmlRpcValue::TypeArray && i < value.size(); ++i) {
    if (!take(value[i], row)) return "row " + std::to_string(i) + " is not";
  }
  return describe(value, row);
}

}  // namespace

ParamReader::ParamReader(const ros::NodeHandle& node_handle)
    : ParamReader(parametersOf(node_handle), node_handle.getNamespace() + "/") {}

ParamReader::ParamReader(ParameterMap parameters, std::string prefix)
    : parameters_(std::move(parameters)), prefix_(std::move(prefix)) {}

bool ParamReader::fail(const std::string& name, const std::string& why) {
  if (failed_names_.insert(name).second) {
    Parameters::addError("parameter " + prefix_ + name + " " + why);
  }
  return false;
}

/// Null, and an error, when there is none of that name.
XmlRpcValue* ParamReader::find(const std::string& name) {
  names_.insert(name);
  const auto found = parameters_.find(name);
  if (found != parameters_.end()) {
    texts_[name] = yamlOf(found->second);
    return &found->second;
  }
  const auto below = parameters_.lower_bound(name + "/");
  const bool is_group = below != parameters_.end() && below->first.rfind(name + "/", 0) == 0;
  fail(name, is_group ? "must be a value, but is a group of parameters" : "is missing");
  return nullptr;
}

bool ParamReader::readInto(const std::string& name, const Target& target) {
  XmlRpcValue* found = find(name);
  if (found == nullptr) return false;
  if (isRequired(*found, target)) return readRequired(name, target);
  return std::visit(
      [&](auto* value) {
        return take(*found, *value) ||
               fail(name, "must be " + kindOf(*value) + ", but " + describe(*found, *value));
      },
      target);
}

bool ParamReader::readRequired(const std::string& name, const Target& target) {
  const auto stand_in = stand_ins_.find(name);
  if (stand_in != stand_ins_.end()) {
    if (const auto* number = std::get_if<double*>(&target)) **number = stand_in->second;
    if (const auto* integer = std::get_if<int*>(&target)) {
      **integer = static_cast<int>(stand_in->second);
    }
    return true;
  }
  if (failed_names_.insert(name).second) {
    required_.push_back("parameter " + prefix_ + name + " is required: a number of your " +
                        ownerOf(name));
  }
  return false;
}

std::string ParamReader::takeRequired() {
  const std::vector<std::string> sentences = std::exchange(required_, {});
  return sentences.empty() ? std::string() : listed(sentences);
}

std::vector<std::string> ParamReader::namesIn(const std::string& group) const {
  const std::string beginning = group + "/";
  std::vector<std::string> names;
  for (auto next = parameters_.lower_bound(beginning);
       next != parameters_.end() && next->first.rfind(beginning, 0) == 0; ++next) {
    names.push_back(next->first.substr(beginning.size()));
  }
  return names;
}

void ParamReader::addError(const std::string& sentence) {
  std::istringstream words(sentence);
  const bool speaks_of_failed = std::any_of(
      std::istream_iterator<std::string>(words), std::istream_iterator<std::string>(),
      [this](const std::string& word) {
        return failed_names_.count(word.substr(0, word.find_last_not_of(":;,.") + 1)) != 0;
      });
  const bool is_said = std::count(errors().begin(), errors().end(), sentence) > 0;
  if (!speaks_of_failed && !is_said) Parameters::addError(sentence);
}

void ParamReader::findUnknownNames() {
  std::set<std::string> groups;
  for (const std::string& name : names_) groups.insert(groupOf(name));
  groups.erase("");  // other libraries put parameters of their own at the top level
  for (const auto& [name, value] : parameters_) {
    if (groups.count(groupOf(name)) != 0 && names_.count(name) == 0) {
      addError("parameter " + prefix_ + name + " is not known (misspelt?)");
    }
  }
}

void ParamReader::throwIfAnyError() {
  findUnknownNames();
  std::vector<std::string> all = required_;
  all.insert(all.end(), errors().begin(), errors().end());
  if (!all.empty()) throw std::runtime_error(listed(all));
}

}  // namespace bearing_calibration_ros
