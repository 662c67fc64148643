#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <type_traits>
#include <vector>

#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {

/// Writes fields as YAML; strings are quoted, numbers in their shortest form.
class YamlWriter {
 public:
  YAML::Emitter out;

  template <class Value>
  void operator()(const std::string& key, const Value& value) {
    begin(key);
    if constexpr (std::is_same_v<Value, double>) {
      out << shortestText(value);
    } else if constexpr (std::is_convertible_v<Value, std::string>) {
      out << YAML::DoubleQuoted << std::string(value);
    } else if constexpr (std::is_same_v<Value, CalibrationState>) {
      out << YAML::DoubleQuoted << nameOf(value);
    } else if constexpr (std::is_same_v<Value, Stamp>) {
      out << value.time_since_epoch().count();
    } else {
      out << value;
    }
  }
  void operator()(const std::string& key, const std::vector<std::string>& texts) {
    list(key, texts, [this](const std::string& text) { out << YAML::DoubleQuoted << text; });
  }
  template <class Part>
  void group(const std::string& key, const Part& part, bool on_one_line = false) {
    begin(key);
    if (on_one_line) out << YAML::Flow;
    out << YAML::BeginMap;
    part(*this);
    out << YAML::EndMap;
  }
  /// One line for each row. @param entry  (row, column) -> number
  template <class Entry>
  void covariance(const std::string& key, int size, const Entry& entry) {
    begin(key) << YAML::BeginSeq;
    for (int row = 0; row < size; ++row) {
      out << YAML::Flow << YAML::BeginSeq;
      for (int column = 0; column < size; ++column) out << shortestText(entry(row, column));
      out << YAML::EndSeq;
    }
    out << YAML::EndSeq;
  }
  /// What is for people, and not read.
  template <class Part>
  void forPeople(const Part& part) {
    part(*this);
  }
  /// @param write_one  of the items
  template <class Items, class One>
  void list(const std::string& key, const Items& items, const One& write_one) {
    begin(key);
    if (items.empty()) out << YAML::Flow;
    out << YAML::BeginSeq;
    for (const auto& item : items) write_one(item);
    out << YAML::EndSeq;
  }
  YAML::Emitter& begin(const std::string& key) { return out << YAML::Key << key << YAML::Value; }
};

}  // namespace bearing_calibration::core
