#include "bearing_calibration_ros/param_reader.h"

#include <ros/param.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration_ros {
namespace {

using XmlRpc::XmlRpcValue;

std::string groupOf(const std::string& name) {
  const std::size_t slash = name.find('/');
  return slash == std::string::npos ? std::string() : name.substr(0, slash + 1);
}

bool isGroup(const XmlRpcValue& value) { return value.getType() == XmlRpcValue::TypeStruct; }

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

/// A value as its writer would recognise it, with its kind where that is the trouble.
std::string textOf(XmlRpcValue& value) {
  std::ostringstream text;
  text << std::boolalpha;
  switch (value.getType()) {
    case XmlRpcValue::TypeString: {
      const std::string string = value;
      char* end = nullptr;
      const double number = std::strtod(string.c_str(), &end);
      const bool looks_like_number = !string.empty() && *end == '\0' && std::isfinite(number);
      text << "the string '" << string << "'";
      if (looks_like_number) text << " (YAML wants a point and no quotes: 1.0e-6)";
      break;
    }
    case XmlRpcValue::TypeBoolean:
      text << static_cast<bool>(value);
      break;
    case XmlRpcValue::TypeArray:
      text << "a list of " << value.size();
      break;
    case XmlRpcValue::TypeStruct:
      text << "a group of parameters";
      break;
    default:
      text << value;
  }
  return text.str();
}

/// All parameters below the node's name, in one request to the master.
XmlRpcValue treeOf(const ros::NodeHandle& node_handle) {
  XmlRpcValue tree;
  ros::param::get(node_handle.getNamespace(), tree);  // stays empty when there are none
  return tree;
}

/// Full names of all values below `tree`, groups joined by slashes.
void listNames(XmlRpcValue& tree, const std::string& prefix, std::vector<std::string>* names) {
  if (!isGroup(tree)) {
    names->push_back(prefix);
    return;
  }
  for (auto& [name, value] : tree) {
    listNames(value, prefix.empty() ? name : prefix + "/" + name, names);
  }
}

/// A value as it would stand in a YAML file.
std::string yamlOf(XmlRpcValue& value) {
  std::string list;
  double number = 0.0;
  switch (value.getType()) {
    case XmlRpcValue::TypeString:
      return '"' + static_cast<std::string>(value) + '"';
    case XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpcValue::TypeArray:
      for (int i = 0; i < value.size(); ++i) list += (i == 0 ? "" : ", ") + yamlOf(value[i]);
      return '[' + list + ']';
    default:
      return take(value, number) ? core::shortestText(number) : "";
  }
}

}  // namespace

XmlRpcValue* findIn(XmlRpcValue* tree, const std::string& name) {
  const std::size_t slash = name.find('/');
  const std::string first = name.substr(0, slash);
  if (!isGroup(*tree) || !tree->hasMember(first)) return nullptr;
  XmlRpcValue* child = &(*tree)[first];
  return slash == std::string::npos ? child : findIn(child, name.substr(slash + 1));
}

std::vector<std::string> namesIn(XmlRpcValue& tree) {
  std::vector<std::string> names;
  if (isGroup(tree)) listNames(tree, "", &names);
  return names;
}

ParamReader::ParamReader(const ros::NodeHandle& node_handle)
    : ParamReader(treeOf(node_handle), node_handle.getNamespace() + "/") {}

ParamReader::ParamReader(const XmlRpcValue& tree, const std::string& prefix)
    : tree_(tree), prefix_(prefix) {}

bool ParamReader::fail(const std::string& name, const std::string& why) {
  if (failed_names_.insert(name).second) {
    Parameters::addError("parameter " + prefix_ + name + " " + why);
  }
  return false;
}

/// Null, and an error, when there is none of that name.
XmlRpcValue* ParamReader::find(const std::string& name) {
  names_.insert(name);
  XmlRpcValue* found = findIn(&tree_, name);
  if (found == nullptr) {
    fail(name, "is missing");
  } else {
    texts_[name] = yamlOf(*found);
  }
  return found;
}

template <typename Value>
bool ParamReader::readAs(const std::string& kind, const std::string& name, Value& value) {
  XmlRpcValue* found = find(name);
  if (found == nullptr) return false;
  return take(*found, value) || fail(name, "must be " + kind + ", but is " + textOf(*found));
}

bool ParamReader::read(const std::string& name, double& value) {
  return readAs("a finite number", name, value);
}
bool ParamReader::read(const std::string& name, int& value) {
  return readAs("an integer", name, value);
}
bool ParamReader::read(const std::string& name, bool& value) {
  return readAs("true or false", name, value);
}
bool ParamReader::read(const std::string& name, std::string& value) {
  return readAs("a string", name, value);
}
bool ParamReader::read(const std::string& name, std::vector<double>& values) {
  return readAs("a list of " + std::to_string(values.size()) + " finite numbers", name, values);
}

bool ParamReader::read(const std::string& name, std::size_t row_size, Rows& rows) {
  const std::string kind = "a list of lists of " + std::to_string(row_size) + " finite numbers";
  XmlRpcValue* found = find(name);
  if (found == nullptr) return false;
  if (found->getType() != XmlRpcValue::TypeArray) {
    return fail(name, "must be " + kind + ", but is " + textOf(*found));
  }
  Rows all(static_cast<std::size_t>(found->size()), std::vector<double>(row_size));
  for (int i = 0; i < found->size(); ++i) {
    if (take((*found)[i], all[static_cast<std::size_t>(i)])) continue;
    return fail(name, "must be " + kind + ", but row " + std::to_string(i) + " is not");
  }
  rows = all;
  return true;
}

void ParamReader::addError(const std::string& sentence) {
  std::istringstream words(sentence);
  const bool speaks_of_failed =
      std::any_of(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>(),
                  [this](const std::string& word) { return failed_names_.count(word) != 0; });
  const bool is_said = std::count(errors().begin(), errors().end(), sentence) > 0;
  if (!speaks_of_failed && !is_said) Parameters::addError(sentence);
}

void ParamReader::findUnknownNames() {
  std::set<std::string> groups;
  for (const std::string& name : names_) groups.insert(groupOf(name));
  groups.erase("");  // other libraries put parameters of their own at the top level
  for (const std::string& name : namesIn(tree_)) {
    if (groups.count(groupOf(name)) != 0 && names_.count(name) == 0) {
      addError("parameter " + prefix_ + name + " is not known (misspelt?)");
    }
  }
}

void ParamReader::throwIfAnyError() {
  findUnknownNames();
  if (errors().empty()) return;
  std::string message = std::to_string(errors().size()) + " wrong parameter(s):";
  for (const std::string& error : errors()) message += "\n  - " + error;
  throw std::runtime_error(message);
}

}  // namespace bearing_calibration_ros
