#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/output/yaml_writer.h"

// A file's fields are listed once, by a function that a YamlWriter and a YamlReader go through:
// walk("key", value) writes the value, or reads it.

namespace bearing_calibration::core {

/// Reads fields. What is wrong is thrown as std::runtime_error, with the key.
class YamlReader {
 public:
  explicit YamlReader(const YAML::Node& node) : node_(node) {}

  bool has(const std::string& key) const { return node_[key].IsDefined(); }

  template <class Value>
  void operator()(const std::string& key, Value& value) const {
    value = as<Value>(key);
    if constexpr (std::is_same_v<Value, double>) {
      if (!std::isfinite(value)) throw std::runtime_error("'" + key + "' is not finite");
    }
  }
  void operator()(const std::string& key, Stamp& stamp) const {
    stamp = stampFromNanoseconds(as<std::int64_t>(key));
  }
  void operator()(const std::string& key, CalibrationState& state) const {
    const auto name = as<std::string>(key);
    for (int value = 0; value <= static_cast<int>(CalibrationState::kPaused); ++value) {
      state = static_cast<CalibrationState>(value);
      if (name == nameOf(state)) return;
    }
    throw std::runtime_error("'" + key + "' is none that is known: " + name);
  }
  template <class Part>
  void group(const std::string& key, const Part& part, bool /*on_one_line*/ = false) const {
    const YamlReader inner(child(key));
    part(inner);
  }
  /// Symmetric, no negative eigenvalue, no variance of zero.
  template <class Entry>
  void covariance(const std::string& key, int size, const Entry& entry) const {
    const auto rows = as<std::vector<std::vector<double>>>(key);
    const auto count = static_cast<std::size_t>(size);
    const bool is_square =
        rows.size() == count &&
        std::all_of(rows.begin(), rows.end(), [&](auto& row) { return row.size() == count; });
    if (!is_square) {
      throw std::runtime_error(
          formatted("'%s' does not have %dx%d numbers", key.c_str(), size, size));
    }
    Eigen::MatrixXd matrix(size, size);
    for (int i = 0; i < size; ++i) {
      for (int k = 0; k < size; ++k) {
        matrix(i, k) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
        entry(i, k) = matrix(i, k);
      }
    }
    if (!isCovariance(matrix)) throw std::runtime_error("'" + key + "' is not a covariance");
  }
  template <class Part>
  void forPeople(const Part& /*part*/) const {}

 private:
  static bool isCovariance(const Eigen::MatrixXd& matrix) {
    constexpr double kRounding = 1e-9;  // relative; far above that of an update in doubles
    const double rounding = kRounding * matrix.cwiseAbs().maxCoeff();
    return matrix.allFinite() && matrix.diagonal().minCoeff() > 0.0 &&
           (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= rounding &&
           eigenOf(matrix).values.minCoeff() >= -rounding;
  }

  template <class Value>
  Value as(const std::string& key) const {
    const YAML::Node node = child(key);
    try {
      return node.as<Value>();
    } catch (const YAML::Exception&) {
      throw std::runtime_error("'" + key + "' has a value of a wrong kind");
    }
  }

  YAML::Node child(const std::string& key) const {
    const YAML::Node node = node_.IsMap() ? node_[key] : YAML::Node(YAML::NodeType::Undefined);
    if (!node.IsDefined()) throw std::runtime_error("'" + key + "' is missing");
    return node;
  }

  const YAML::Node node_;
};

}  // namespace bearing_calibration::core
