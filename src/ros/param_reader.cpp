#include "bearing_calibration_ros/param_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

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

}  // namespace

bool ParamReader::find(const std::string& name, XmlRpc::XmlRpcValue* value) {
  names_.insert(name);
  if (node_handle_.getParam(name, *value)) return true;
  addError("parameter " + node_handle_.resolveName(name) + " is missing");
  return false;
}

double ParamReader::number(const std::string& name) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return kNone;
  if (isNumber(value) && std::isfinite(numberFrom(value))) return numberFrom(value);
  addError("parameter " + node_handle_.resolveName(name) + " must be a finite number, but is " +
           value.toXml());
  return kNone;
}

int ParamReader::integer(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return 0;
  if (value.getType() == XmlRpc::XmlRpcValue::TypeInt) return value;
  addError("parameter " + node_handle_.resolveName(name) + " must be an integer, but is " +
           value.toXml());
  return 0;
}

bool ParamReader::boolean(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return false;
  if (value.getType() == XmlRpc::XmlRpcValue::TypeBoolean) return value;
  addError("parameter " + node_handle_.resolveName(name) + " must be true or false, but is " +
           value.toXml());
  return false;
}

std::string ParamReader::text(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return {};
  if (value.getType() == XmlRpc::XmlRpcValue::TypeString) return value;
  addError("parameter " + node_handle_.resolveName(name) + " must be a string, but is " +
           value.toXml());
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
  addError("parameter " + node_handle_.resolveName(name) + " must be one of (" + list +
           "), but is '" + value + "'");
  return 0;
}

std::vector<std::vector<double>> ParamReader::rows(const std::string& name, std::size_t row_size) {
  XmlRpc::XmlRpcValue value;
  if (!find(name, &value)) return {};
  const std::string error = "parameter " + node_handle_.resolveName(name) +
                            " must be a list of lists of " + std::to_string(row_size) +
                            " finite numbers";
  if (value.getType() != XmlRpc::XmlRpcValue::TypeArray) {
    addError(error);
    return {};
  }
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < value.size(); ++i) {
    XmlRpc::XmlRpcValue& row = value[i];
    bool good = row.getType() == XmlRpc::XmlRpcValue::TypeArray &&
                static_cast<std::size_t>(row.size()) == row_size;
    std::vector<double> numbers;
    for (int j = 0; good && j < row.size(); ++j) {
      good = isNumber(row[j]) && std::isfinite(numberFrom(row[j]));
      if (good) numbers.push_back(numberFrom(row[j]));
    }
    if (!good) {
      addError(error);
      return {};
    }
    rows.push_back(numbers);
  }
  return rows;
}

void ParamReader::addErrors(const std::vector<std::string>& errors) {
  errors_.insert(errors_.end(), errors.begin(), errors.end());
}

void ParamReader::findUnknownNames() {
  std::set<std::string> groups;
  for (const std::string& name : names_) groups.insert(groupOf(name));
  groups.erase("");  // other libraries put parameters of their own at the top level
  std::vector<std::string> all_names;
  if (!node_handle_.getParamNames(all_names)) return;
  const std::string prefix = node_handle_.getNamespace() + "/";
  for (const std::string& full_name : all_names) {
    if (full_name.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string name = full_name.substr(prefix.size());
    if (groups.count(groupOf(name)) != 0 && names_.count(name) == 0) {
      addError("parameter " + full_name + " is not known (misspelt?)");
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
