#include "bearing_calibration_ros/param_reader.h"

#include <ros/param.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "bearing_calibration/output/result_file.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {
namespace {

std::string groupOf(const std::string& name) {
  const std::size_t slash = name.find('/');
  return slash == std::string::npos ? std::string() : name.substr(0, slash + 1);
}

bool isNumber(XmlRpc::XmlRpcValue& value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeInt ||
         value.getType() == XmlRpc::XmlRpcValue::TypeDouble;
}

double numberFrom(XmlRpc::XmlRpcValue& value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeInt
             ? static_cast<double>(static_cast<int>(value))
             : static_cast<double>(value);
}

/// False, and `numbers` as it was, unless `value` is a list of `count` finite numbers.
bool readNumbers(XmlRpc::XmlRpcValue& value, std::size_t count, std::vector<double>* numbers) {
  if (value.getType() != XmlRpc::XmlRpcValue::TypeArray) return false;
  std::vector<double> read;
  for (int i = 0; i < value.size(); ++i) {
    if (!isNumber(value[i]) || !std::isfinite(numberFrom(value[i]))) return false;
    read.push_back(numberFrom(value[i]));
  }
  if (read.size() != count) return false;
  *numbers = read;
  return true;
}

/// A value as its writer would recognise it, with its kind where that is the trouble.
std::string textOf(XmlRpc::XmlRpcValue& value) {
  std::ostringstream text;
  text << std::boolalpha;
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeString: {
      const std::string string = value;
      char* end = nullptr;
      std::strtod(string.c_str(), &end);
      const bool looks_like_number = !string.empty() && *end == '\0';
      text << "the string '" << string << "'";
      if (looks_like_number) text << " (YAML wants a point and no quotes: 1.0e-6)";
      break;
    }
    case XmlRpc::XmlRpcValue::TypeBoolean:
      text << static_cast<bool>(value);
      break;
    case XmlRpc::XmlRpcValue::TypeArray:
      text << "a list of " << value.size();
      break;
    case XmlRpc::XmlRpcValue::TypeStruct:
      text << "a group of parameters";
      break;
    default:
      text << value;
  }
  return text.str();
}

/// All parameters below the node's name, in one request to the master.
XmlRpc::XmlRpcValue treeOf(const ros::NodeHandle& node_handle) {
  XmlRpc::XmlRpcValue tree;
  ros::param::get(node_handle.getNamespace(), tree);  // stays empty when there are none
  return tree;
}

bool isGroup(const XmlRpc::XmlRpcValue& value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeStruct;
}

/// Full names of all values below `tree`, groups joined by slashes.
void listNames(XmlRpc::XmlRpcValue& tree, const std::string& prefix,
               std::vector<std::string>* names) {
  if (!isGroup(tree)) {
    names->push_back(prefix);
    return;
  }
  for (auto& [name, value] : tree) {
    listNames(value, prefix.empty() ? name : prefix + "/" + name, names);
  }
}

/// A value as it would stand in a YAML file.
std::string yamlOf(XmlRpc::XmlRpcValue& value) {
  std::string list;
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeString:
      return '"' + static_cast<std::string>(value) + '"';
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeArray:
      for (int i = 0; i < value.size(); ++i) list += (i == 0 ? "" : ", ") + yamlOf(value[i]);
      return '[' + list + ']';
    default:
      return isNumber(value) ? core::shortestText(numberFrom(value)) : "";
  }
}

}  // namespace

XmlRpc::XmlRpcValue* findIn(XmlRpc::XmlRpcValue* tree, const std::string& name) {
  const std::size_t slash = name.find('/');
  const std::string first = name.substr(0, slash);
  if (!isGroup(*tree) || !tree->hasMember(first)) return nullptr;
  XmlRpc::XmlRpcValue* child = &(*tree)[first];
  return slash == std::string::npos ? child : findIn(child, name.substr(slash + 1));
}

std::vector<std::string> namesIn(XmlRpc::XmlRpcValue& tree) {
  std::vector<std::string> names;
  if (isGroup(tree)) listNames(tree, "", &names);
  return names;
}

ParamReader::ParamReader(const ros::NodeHandle& node_handle)
    : ParamReader(treeOf(node_handle), node_handle.getNamespace() + "/") {}

ParamReader::ParamReader(const XmlRpc::XmlRpcValue& tree, const std::string& prefix)
    : tree_(tree), prefix_(prefix) {}

void ParamReader::fail(const std::string& name, const std::string& why) {
  failed_names_.insert(name);
  addError("parameter " + prefix_ + name + " " + why);
}

void ParamReader::failKind(const std::string& name, const std::string& kind,
                           XmlRpc::XmlRpcValue& value) {
  fail(name, "must be " + kind + ", but is " + textOf(value));
}

bool ParamReader::find(const std::string& name, XmlRpc::XmlRpcValue* value) {
  names_.insert(name);
  XmlRpc::XmlRpcValue* found = findIn(&tree_, name);
  if (found == nullptr) {
    fail(name, "is missing");
    return false;
  }
  *value = *found;
  texts_[name] = yamlOf(*value);
  return true;
}

double ParamReader::number(const std::string& name) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return kNone;
  if (isNumber(value) && std::isfinite(numberFrom(value))) return numberFrom(value);
  failKind(name, "a finite number", value);
  return kNone;
}

int ParamReader::integer(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return 0;
  if (value.getType() == XmlRpc::XmlRpcValue::TypeInt) return value;
  failKind(name, "an integer", value);
  return 0;
}

bool ParamReader::boolean(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return false;
  if (value.getType() == XmlRpc::XmlRpcValue::TypeBoolean) return value;
  failKind(name, "true or false", value);
  return false;
}

std::string ParamReader::text(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return {};
  if (value.getType() == XmlRpc::XmlRpcValue::TypeString) return value;
  failKind(name, "a string", value);
  return {};
}

std::size_t ParamReader::choice(const std::string& name, const std::vector<std::string>& choices) {
  const std::size_t errors_before = errors_.size();
  const std::string value = text(name);
  if (errors_.size() != errors_before) return 0;
  const auto found = std::find(choices.begin(), choices.end(), value);
  if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  std::string list;
  for (const std::string& option : choices) list += (list.empty() ? "" : ", ") + option;
  fail(name, "must be one of (" + list + "), but is '" + value + "'");
  return 0;
}

std::vector<double> ParamReader::numbers(const std::string& name, std::size_t count) {
  std::vector<double> numbers(count, std::numeric_limits<double>::quiet_NaN());
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return numbers;
  if (!readNumbers(value, count, &numbers)) {
    failKind(name, "a list of " + std::to_string(count) + " finite numbers", value);
  }
  return numbers;
}

std::vector<std::vector<double>> ParamReader::rows(const std::string& name, std::size_t row_size) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return {};
  const std::string kind = "a list of lists of " + std::to_string(row_size) + " finite numbers";
  if (value.getType() != XmlRpc::XmlRpcValue::TypeArray) {
    failKind(name, kind, value);
    return {};
  }
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < value.size(); ++i) {
    XmlRpc::XmlRpcValue& row = value[i];
    std::vector<double> numbers;
    if (!readNumbers(row, row_size, &numbers)) {
      fail(name, "must be " + kind + ", but row " + std::to_string(i) + " is not");
      return {};
    }
    rows.push_back(numbers);
  }
  return rows;
}

void ParamReader::addErrors(const std::vector<std::string>& errors) {
  for (const std::string& error : errors) {
    std::istringstream words(error);
    const bool speaks_of_failed =
        std::any_of(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>(),
                    [this](const std::string& word) { return failed_names_.count(word) != 0; });
    if (!speaks_of_failed) addError(error);
  }
}

void ParamReader::findUnknownNames() {
  std::set<std::string> groups;
  for (const std::string& name : names_) groups.insert(groupOf(name));
  groups.erase("");  // other libraries put parameters of their own at the top level
  if (!isGroup(tree_)) return;
  std::vector<std::string> all_names;
  listNames(tree_, "", &all_names);
  for (const std::string& name : all_names) {
    if (groups.count(groupOf(name)) != 0 && names_.count(name) == 0) {
      addError("parameter " + prefix_ + name + " is not known (misspelt?)");
    }
  }
}

void ParamReader::throwIfAnyError() {
  findUnknownNames();
  if (errors_.empty()) return;
  std::string message = std::to_string(errors_.size()) + " wrong parameter(s):";
  for (const std::string& error : errors_) message += "\n  - " + error;
  throw std::runtime_error(message);
}

}  // namespace bearing_calibration_ros
